"""What a picture of a laser's line on a known surface tells."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._references import Reference
from calibore.errors import InputError

Array = NDArray[np.float64]
WIDER, BESIDE = 1.5, 4
"""A step that leaves a mark out is so many times as wide as the usual one of so many on each side."""


@dataclass(frozen=True, eq=False)
class Look:
    """Marks at `u`, `v` (n,) [px] on the line that `laser` draws on `reference`, in order along the line, each measured
    along the unit vector `direction` (n, 2) with standard uncertainty `sigma` (n,) [px].

    `name`: what people call it ("8.1 in"). Looks of one `setting` share how the reference was set up, those of one
    `stop` its error in size or place; None: this look has its own. `file`: index among those of the calibration.
    """

    u: Array
    v: Array
    direction: Array
    sigma: Array
    reference: Reference
    name: str
    laser: int = 0
    setting: str | None = None
    stop: str | None = None
    file: int = 0

    def __post_init__(self) -> None:
        n = self.u.size
        if n == 0 or not self.v.shape == self.sigma.shape == (n,) or self.direction.shape != (n, 2):
            raise InputError(f"The look {self.name} needs marks, each with a place, a direction and an uncertainty.")
        if not (self.sigma > 0).all():
            raise InputError(f"Marks of the look {self.name} need a positive standard uncertainty.")

    @property
    def chain(self) -> NDArray[np.intp]:
        """(n,) number of the stretch that each mark belongs to; where marks are missing, the next is no neighbour."""
        if self.u.size == 1:
            return np.zeros(1, dtype=np.intp)
        steps = np.diff(np.stack([self.u, self.v], axis=1), axis=0)
        across = np.abs(steps[:, 0] * self.direction[:-1, 1] - steps[:, 1] * self.direction[:-1, 0])
        gaps = across > WIDER * _usual(across)
        return np.concatenate([[0], np.cumsum(gaps)]).astype(np.intp)

    @property
    def of_setting(self) -> str:
        return self.name if self.setting is None else self.setting

    @property
    def of_stop(self) -> str:
        return self.name if self.stop is None else self.stop


def _usual(steps: Array) -> Array:
    """The median of the steps about each of `steps` (n,)."""
    padded = np.pad(steps, BESIDE, mode="reflect") if steps.size > BESIDE else np.pad(steps, BESIDE, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * BESIDE + 1), axis=1)

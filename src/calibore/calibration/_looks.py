"""What a picture of a laser's line on a known surface tells."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._references import Reference
from calibore.errors import InputError

Array = NDArray[np.float64]


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
    def of_setting(self) -> str:
        return self.name if self.setting is None else self.setting

    @property
    def of_stop(self) -> str:
        return self.name if self.stop is None else self.stop

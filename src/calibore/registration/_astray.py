"""A solution that lies where nothing was looked for, and does not fit there either, is none."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calibore.errors import InputError

FAR = 1.25
"""Prior standard deviations from its start beyond which a parameter is outside what was searched."""
LEFT = 0.5
"""Of the points that lie on the reference at the start: a solution that leaves fewer has slid off."""
FITS = 2.0
"""Times the stated noise: residuals no larger than that are evidence enough, wherever a solution lies."""
WORDS = {
    "roll": "turns them by {:.3g} deg from its start, where 10 deg are searched",
    "shift_x": "moves them sideways by {:.3g} mm from its start, where 5 % of the radius are searched",
    "shift_y": "moves them vertically by {:.3g} mm from its start, where 5 % of the radius are searched",
    "axial": "moves them along the pipe by {:.3g} mm from its start, where two stations are searched",
}


class AstrayError(InputError):
    """Two profiles are not brought together by the best motion; `found` says, as part of a sentence, what it does."""

    def __init__(self, found: str) -> None:
        self.found = found
        super().__init__(
            f"The profiles are not brought together: {found}. Check that both are of one pipe and of the same stretch "
            "of it, or give a start that is nearer."
        )

    def __reduce__(self) -> tuple[type, tuple[str]]:
        return type(self), (self.found,)


@dataclass(frozen=True)
class Walk:
    """What a solution did: `moved` from its start, by parameter that the profiles tell, with `prior` standard
    deviations and `u`; `left` of the points that were `there` at the start; `scatter` of residuals over their noise.
    """

    moved: Mapping[str, float]
    prior: Mapping[str, float]
    u: Mapping[str, float]
    there: int
    left: int
    scatter: float

    def check(self) -> None:
        """Raises AstrayError where it went too far for what it found."""
        if self.scatter <= FITS:
            return
        misfit = f"and what is left of their difference is {self.scatter:.2g} times their noise"
        for name, words in WORDS.items():
            if abs(self.moved.get(name, 0.0)) > FAR * self.prior.get(name, np.inf) + 2 * self.u.get(name, 0.0):
                size = np.degrees(self.moved[name]) if name == "roll" else 1e3 * self.moved[name]
                raise AstrayError(f"the best motion {words.format(abs(size))}, {misfit}")
        if self.left < LEFT * self.there:
            raise AstrayError(
                f"the best motion slides them apart, so that {self.left} points have a counterpart, of {self.there} "
                f"before, {misfit}"
            )

"""Two calibrations compared over the image and on the wall: is this the same camera as last year?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from calibore.calibration._difference._changes import Change, changes
from calibore.calibration._difference._directions import DirectionDifference, compare_directions
from calibore.calibration._difference._sides import Known, alike, side_of
from calibore.calibration._difference._test import Judgement, judged
from calibore.calibration._difference._wall import WallDifference, comparable, compare_walls, compared_radii
from calibore.calibration._difference._words import verdict_of
from calibore.errors import InputError


@dataclass(frozen=True, eq=False)
class Difference:
    """`directions` over the image; what they mean on the `wall` of `nominal_radius` [m] (rigs of one configuration,
    else None); `changes` of parameters, the one that explains most first; `judgement` of all of it together.
    `same_law`: whether the lenses can be compared parameter by parameter; `stated`: whether each side states its
    uncertainty.
    """

    directions: DirectionDifference
    wall: WallDifference | None
    changes: tuple[Change, ...]
    judgement: Judgement
    nominal_radius: float | None
    same_law: bool
    stated: tuple[bool, bool]

    @property
    def p(self) -> float:
        """Probability of a difference at least as large between two calibrations of one unchanged rig."""
        return self.judgement.p

    def verdict(self, unit: str = "mm") -> str:
        """The answer in sentences, lengths in "mm" or "in"."""
        return verdict_of(self, unit)


def difference(
    a: Known,
    b: Known,
    *,
    nominal_radius: float | None = None,
    radii: ArrayLike | None = None,
) -> Difference:
    """`b` minus `a`: rigs, cameras with covariance (`rigs.read_camera`), or calibrations, independent of each other.

    Directions are compared, so lenses of different laws can be, after the turn that one camera may have made in its
    frame is taken out. Rigs of one configuration are compared on walls of `radii` [m] round `nominal_radius` too: what
    b makes of the pictures of a, less the shift across the pipe that every ring's centre takes up. Chi-square is over
    the directions that the covariances allow; which calibration is right, it does not tell.
    """
    first, second = side_of(a), side_of(b)
    along, evidence = compare_directions(first, second)
    wall, judgement = None, along.judgement
    if comparable(first, second):
        if nominal_radius is None or not 0 < nominal_radius < np.inf:
            raise InputError(
                f"Two rigs are compared on a wall, whose nominal radius is {nominal_radius}; give it, in metres."
            )
        chosen = compared_radii(first, second, nominal_radius) if radii is None else np.asarray(radii, dtype=float)
        wall, on_wall = compare_walls(first, second, np.union1d(chosen, [nominal_radius]), nominal_radius)
        judgement = judged(evidence.beside(on_wall))
    return Difference(
        along,
        wall,
        changes(first, second),
        judgement,
        nominal_radius,
        alike(first, second),
        (first.stated, second.stated),
    )

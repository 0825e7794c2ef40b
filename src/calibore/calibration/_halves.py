"""Cross-validation: half of the pictures against the other half, from a calibration's evidence alone.

Both halves are solved in first order at the solution of all, from residuals, weights and Jacobian; what they differ by
in the image shows errors that no covariance of one fit can, such as a lens law that does not suit (mrcal).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._difference._sides import side_of
from calibore.calibration._difference._test import Evidence, judged
from calibore.calibration._halves_data import HalvesData
from calibore.calibration._in_words import PIXEL, Unit, probability
from calibore.calibration._on_the_wall import root_mean_square, wall_clocks, wall_slopes
from calibore.calibration._projection import image_grid, implied_turns, projection_slopes, turns_against
from calibore.errors import InputError
from calibore.rigs import Rig

Array = NDArray[Any]
WELL_BELOW = 0.2
"""px rms: halves that agree as well are one camera (mrcal)."""
CHANCE = 0.01
FEWEST = 4
"""Pictures from which on whole pictures are parted, not groups of marks."""
OUTWEIGHED = 0.5
"""Of the stated uncertainty; halves of pictures that alone tell the camera differ by twice of it."""


class Halves(NamedTuple):
    """At pixels `u`, `v` (n,): where the second half images the directions of the first, less that, as `difference`
    (n, 2) [px], after a turn; `rms` [px] of it, and `expected` [px] by the covariance stated for the whole; `p` of at
    least as large a difference by chance. `parts`: what was parted, and into how many. On the wall of
    `nominal_radius` [m], of rigs: `wall_rms` and `wall_expected` [m], else NaN. `outweighed`: what was known of the
    camera before, which both halves share, counts far more than what they tell.
    """

    u: Array
    v: Array
    difference: Array
    rms: float
    expected: float
    p: float
    parts: tuple[str, int, int]
    nominal_radius: float | None
    wall_rms: float
    wall_expected: float
    outweighed: bool

    @property
    def agree(self) -> bool:
        """Within 0.2 px, mrcal's criterion."""
        return self.rms <= WELL_BELOW

    def verdict(self, unit: str = "mm") -> str:
        """In sentences, lengths in "mm" or "in"."""
        outweighed = " The camera was known before better than these pictures tell it, so they hardly check it."
        return f"{self._answer(unit)}{outweighed if self.outweighed else ''}"

    def _answer(self, unit: str) -> str:
        what, first, second = self.parts
        rms, expected = map(PIXEL.roughly, (self.rms, self.expected))
        asked = f"{first} {what} against {second}: {rms} rms apart, {expected} expected"
        if self.p < CHANCE:
            more = ". That is more than chance" if self.rms > self.expected else ", but more than chance where less is"
            return (
                f"{asked}{more} ({probability(self.p)}): the model does not describe this camera "
                "within its stated uncertainty; try a lens with more parameters, and see which pictures have large "
                "residuals."
            )
        if np.isfinite(self.wall_rms):
            apart, expected = map(Unit.of_length(f"1 {unit}").roughly, (self.wall_rms, self.wall_expected))
            return f"{asked}; no more than chance. On the wall {apart} rms, {expected} expected."
        limit = "within" if self.agree else "but more than"
        return f"{asked}; no more than chance, {limit} the {WELL_BELOW} px that well-founded calibrations keep."


def halves(calibration: Calibration, *, nominal_radius: float | None = None) -> Halves:
    """Every other picture against the rest; every other group of marks where there are fewer than four pictures.

    Both are told what was known before, and the errors of groups that reach over both; these are no difference.
    Expected is what the stated covariance says of halves: its neighbours' correlation counts by its ratio to that of
    uncorrelated marks. Raises InputError where the evidence is gone, or half of it does not determine the camera.
    """
    side, seen = side_of(calibration), calibration.observations
    names = [name for name in calibration.covariance.names if name in seen.names]
    moving = [name for name in names if name in side.camera.parameter_names]
    if not seen.residual.size or not moving:
        raise InputError(
            "There is no evidence of a camera to part into halves; keep what `calibore calibrate` writes beside the "
            "file, and give a calibration of a lens or a rig."
        )
    unit, of = _parts(seen)
    parted = np.unique(of)
    stated = calibration.covariance.restricted(names).factor()
    data = HalvesData(seen, names, _group_sigma(calibration))
    pixels = image_grid(side.camera, valid=calibration.valid)
    slopes, turns = projection_slopes(side.camera, *pixels)
    slopes = slopes[:, :, [side.camera.parameter_names.index(name) for name in moving]]
    chosen = np.array([name in moving for name in names])
    weights = implied_turns(slopes @ stated[chosen], turns).weights

    def in_image(factor: Array) -> Array:
        motion = slopes @ factor[chosen]
        return motion + turns @ turns_against(motion, turns, weights)

    inflation = data.inflation(stated, in_image)
    one, other = (data.solved(np.isin(of, parted[start::2]), inflation) for start in (0, 1))
    change = other.change - one.change
    factors = [inflation * np.hstack([one.own, other.shared - one.shared]), inflation * other.own]
    found, count = in_image(change[:, None]), 2 * pixels[0].size
    first, second = (in_image(factor).reshape(count, -1) for factor in factors)
    freedom = side.degrees_of_freedom, side.degrees_of_freedom
    evidence = Evidence(found.ravel(), found.ravel(), first, second, freedom)
    expected = float(np.sqrt(2) * evidence.expected)
    return Halves(
        *pixels,
        found[:, :, 0],
        float(np.sqrt(2) * np.sqrt((found**2).mean())),
        expected,
        judged(evidence).p,
        (unit, parted[::2].size, parted[1::2].size),
        nominal_radius,
        *_on_wall(side.rig, names, change, factors, nominal_radius),
        data.known.size > 0 and expected < OUTWEIGHED * float(np.sqrt(2 / count) * _size(in_image(stated))),
    )


def _group_sigma(calibration: Calibration) -> float:
    """Standard deviation of what groups share, in the unit of which `load` says what it does to residuals."""
    seen = calibration.observations
    known = seen.known_group_sigma
    return calibration.group_sigma / seen.typical_load if known is None else known


def _parts(seen: Observations) -> tuple[str, NDArray[np.intp]]:
    """What the data is parted by, and to which part each residual belongs."""
    used = seen.weight > 0
    if np.unique(seen.file[used]).size >= FEWEST:
        return "pictures", np.where(used, seen.file, seen.file[used][0])
    if np.unique(seen.group[used]).size < FEWEST:
        raise InputError(
            "The calibration has fewer than four pictures, and fewer than four groups of marks, too few to check one "
            "half against the other; photograph the target more often."
        )
    return "groups of marks", np.where(used, seen.group, seen.group[used][0])


def _on_wall(
    rig: Rig | None, names: list[str], change: Array, factors: list[Array], nominal_radius: float | None
) -> tuple[float, float]:
    if rig is None or nominal_radius is None or rig.covariance is None:
        return float("nan"), float("nan")
    columns = [rig.parameter_names.index(name) for name in names]
    slopes = wall_slopes(rig, np.array([nominal_radius]), wall_clocks(rig))[0][:, columns]
    expected = np.sqrt(sum(((slopes @ factor) ** 2).sum(axis=1) for factor in factors))
    return float(root_mean_square(slopes @ change)), float(root_mean_square(expected))


def _size(motion: Array) -> float:
    return float(np.sqrt((motion**2).sum()))

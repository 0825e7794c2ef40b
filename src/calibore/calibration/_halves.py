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
from calibore.calibration._in_words import Unit
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
LOST = 1e-9
"""Of the largest: directions in which half of the data tells nothing."""


class Halves(NamedTuple):
    """At pixels `u`, `v` (n,): where the second half images the directions of the first, less that, as `difference`
    (n, 2) [px], after a turn; `rms` [px] of it, and `expected` [px] by the covariance stated for the whole; `p` of at
    least as large a difference by chance. `parts`: what was parted, and into how many. On the wall of
    `nominal_radius` [m], of rigs: `wall_rms` and `wall_expected` [m], else NaN.
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

    @property
    def agree(self) -> bool:
        """Within 0.2 px, mrcal's criterion."""
        return self.rms <= WELL_BELOW

    def verdict(self, unit: str = "mm") -> str:
        """In sentences, lengths in "mm" or "in"."""
        what, first, second = self.parts
        asked = f"{first} {what} against {second}: {self.rms:.2g} px rms apart, {self.expected:.2g} px expected"
        if self.p < CHANCE:
            return (
                f"{asked}. That is more than chance (p = {self.p:.1g}): the model does not describe this camera within "
                "its stated uncertainty; try a lens with more parameters, and see which pictures have large residuals."
            )
        if np.isfinite(self.wall_rms):
            size = Unit.of_length(f"1 {unit}").size
            apart, expected = (value / size for value in (self.wall_rms, self.wall_expected))
            return f"{asked}; no more than chance. On the wall {apart:.2g} {unit} rms, {expected:.2g} {unit} expected."
        limit = "within" if self.agree else "but more than"
        return f"{asked}; no more than chance, {limit} the {WELL_BELOW} px that well-founded calibrations keep."


def halves(calibration: Calibration, *, nominal_radius: float | None = None) -> Halves:
    """Every other picture against the rest; every other group of marks where there are fewer than four pictures.

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
    solved = [_solution(seen, np.isin(of, parted[start::2]), names, calibration.group_sigma) for start in (0, 1)]
    whole = _solution(seen, np.ones(of.size, bool), names, calibration.group_sigma)[1]
    change = solved[1][0] - solved[0][0]
    pixels = image_grid(side.camera, valid=calibration.valid)
    slopes, turns = projection_slopes(side.camera, *pixels)
    columns = [side.camera.parameter_names.index(name) for name in moving]
    chosen = np.array([name in moving for name in names])
    slopes = slopes[:, :, columns]
    stated = calibration.covariance.restricted(names).factor()
    factors = [solved[0][1], solved[1][1], whole, stated]
    motions = [slopes @ factor[chosen] for factor in factors] + [slopes @ change[chosen][:, None]]
    weights = implied_turns(motions[3], turns).weights
    motions = [motion + turns @ turns_against(motion, turns, weights) for motion in motions]
    inflation = _size(motions[3]) / _size(motions[2])
    count = 2 * pixels[0].size
    first, second, *_, found = (motion.reshape(count, -1) for motion in motions)
    freedom = side.degrees_of_freedom, side.degrees_of_freedom
    evidence = Evidence(found[:, 0], found[:, 0], inflation * first, inflation * second, freedom)
    wall = _on_wall(side.rig, names, change, [inflation * factor for factor in factors[:2]], nominal_radius)
    return Halves(
        *pixels,
        motions[4][:, :, 0],
        float(np.sqrt(2) * np.sqrt((found**2).mean())),
        float(np.sqrt(2) * evidence.expected),
        judged(evidence).p,
        (unit, parted[::2].size, parted[1::2].size),
        nominal_radius,
        *wall,
    )


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


def _solution(
    seen: Observations, chosen: NDArray[np.bool_], names: list[str], group_sigma: float
) -> tuple[Array, Array]:
    """Change (p,) of the parameters `names` that the `chosen` residuals alone ask for, and a factor (p, p) of its
    covariance; poses and errors of groups fitted beside.
    """
    rows = chosen & (seen.weight > 0)
    weight = np.sqrt(seen.weight[rows]) / seen.sigma[rows]
    jacobian = seen.jacobian[rows] * weight[:, None]
    wanted = [seen.names.index(name) for name in names]
    beside = np.delete(jacobian, wanted, axis=1)
    load = weight * group_sigma * (1.0 if seen.load is None else seen.load[rows])
    groups = _group_columns(seen.group[rows], load)
    prior, aim = _known_beside(seen, wanted)
    left = np.vstack([np.hstack([beside, groups]), np.eye(beside.shape[1] + groups.shape[1])[beside.shape[1] :]])
    left = np.vstack([left, np.hstack([prior, np.zeros((len(prior), groups.shape[1]))])])
    right = np.zeros((len(left), len(names) + 1))
    right[: len(jacobian), :-1] = jacobian[:, wanted]
    right[: len(jacobian), -1] = seen.residual[rows] * weight
    right[len(left) - len(prior) :, -1] = aim
    right = _without(left, right)
    return _least_squares(right[:, :-1], right[:, -1], names)


def _known_beside(seen: Observations, wanted: list[int]) -> tuple[Array, Array]:
    """Rows of what is known beforehand of poses and settings; what is known of the camera is no evidence of a half."""
    if seen.prior is None:
        return np.zeros((0, len(seen.names) - len(wanted))), np.zeros(0)
    apart = ~seen.prior[:, wanted].any(axis=1)
    return np.delete(seen.prior[apart, :-1], wanted, axis=1), seen.prior[apart, -1]


def _group_columns(group: NDArray[np.intp], load: Array) -> Array:
    """(n, g): errors that groups share, in units of their standard deviation."""
    if not load.any():
        return np.zeros((group.size, 0))
    return (group[:, None] == np.unique(group[group >= 0])) * load[:, None]


def _without(left: Array, right: Array) -> Array:
    """`right` less what the columns of `left` explain, dependent ones included."""
    size = np.linalg.norm(left, axis=0)
    left = left[:, size > 0] / size[size > 0]
    if not left.shape[1]:
        return right
    basis, values, _ = np.linalg.svd(left, full_matrices=False)
    basis = basis[:, values > LOST * values[0]]
    return right - basis @ (basis.T @ right)


def _least_squares(jacobian: Array, residual: Array, names: list[str]) -> tuple[Array, Array]:
    size = np.linalg.norm(jacobian, axis=0)
    left, values, turns = np.linalg.svd(jacobian / np.where(size > 0, size, 1.0), full_matrices=False)
    if not size.all() or values[-1] < LOST * values[0]:
        weak = names[int(np.argmin(size))] if not size.all() else names[int(np.argmax(np.abs(turns[-1])))]
        raise InputError(
            f"Half of the pictures does not determine {weak}, so one half cannot check the other; photograph the "
            "target at more places and tilts."
        )
    factor = turns.T / values / size[:, None]
    return factor @ (left.T @ residual), factor


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

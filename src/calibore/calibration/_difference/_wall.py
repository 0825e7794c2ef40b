"""Two rigs compared by what they make of the same pictures: radii on the wall, less what a ring's centre takes up."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._difference._sides import Side, alike_rigs
from calibore.calibration._difference._test import Evidence, Judgement, judged
from calibore.calibration._on_the_wall import on_the_wall, root_mean_square, wall_clocks
from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.rigs import Rig, SideFacing, triangulate
from calibore.status import Status
from calibore.uncertainty import coverage_factor

Array = NDArray[Any]
REACH = (0.6, 1.4)
"""Nominal radii between which walls are compared, where the calibrations do not limit them."""
INNERMOST = 0.1
"""Nominal radii nearer than which there is no wall to compare."""
RADII = 9
STEPS = 6
FEWEST = 8
"""Clocks from which on a ring's centre is taken out."""
BENDING = 2.0
"""Per nominal radius: as for directions, of rigs whose parameters cannot be compared one by one."""


@dataclass(frozen=True, eq=False)
class WallDifference:
    """On walls of `radius` (r,) [m] at `clock` (c,) [rad]: what the second rig makes of the pixels of the first, less
    the radius, as `difference` (r, c) [m] with standard uncertainty `u`, after the `shift` (r, 2) [m] of x, y that a
    ring's centre takes up; NaN where it is not seen. `mean` (r,) over the clocks with `u_mean`; `coverage`: the factor
    of a 95 % band.
    """

    radius: Array
    clock: Array
    difference: Array
    u: Array
    shift: Array
    mean: Array
    u_mean: Array
    coverage: float
    judgement: Judgement

    @property
    def rms(self) -> Array:
        """(r,) [m] over the clocks."""
        return root_mean_square(self.difference)

    @property
    def expected(self) -> Array:
        """(r,) [m] rms that the covariances let expect."""
        return root_mean_square(self.u)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What both make of the same pixels: points (r c, 3) and slopes (r c, p) of the radius, NaN unseen."""

    second: Array
    slopes: tuple[Array, Array]


def compare_walls(a: Side, b: Side, radii: Array, nominal_radius: float) -> tuple[WallDifference, Evidence]:
    """Of two rigs of the same configuration."""
    assert a.rig is not None
    assert b.rig is not None
    clock = wall_clocks(a.rig)
    seen = _seen(a.rig, b.rig, radii, clock)
    size = radii.size, clock.size
    points = seen.second.reshape(*size, 3)
    centred = clock.size >= FEWEST and not isinstance(a.rig.mount, SideFacing)
    shift = np.stack([_shift(*ring) if centred else np.zeros(2) for ring in zip(points, radii, strict=True)])
    moved = points[..., :2] - shift[:, None]
    difference = np.hypot(moved[..., 0], moved[..., 1]) - radii[:, None]
    if not np.isfinite(difference).any():
        raise InputError(
            "The two rigs see no common wall of the radii compared; give the nominal radius that they measure."
        )
    names = a.rig.parameter_names
    slopes = ((seen.slopes[0] + seen.slopes[1]) / 2,) * 2 if alike_rigs(a, b) else seen.slopes
    first, second = (
        _without_shift(_motions(slope, one, names).reshape(*size, -1), clock, centred=centred)
        for slope, one in zip(slopes, (a, b), strict=True)
    )
    linear = difference
    if alike_rigs(a, b):
        change = np.array([b.values[name] - a.values[name] for name in names])
        linear = _without_shift((slopes[0] @ change).reshape(*size, 1), clock, centred=centred)[..., 0]
    evidence = _evidence(difference, linear, first, second, (a.degrees_of_freedom, b.degrees_of_freedom))
    judgement = judged(evidence, curvature=0.0 if alike_rigs(a, b) else BENDING / nominal_radius)
    both = np.concatenate([first, second], axis=2)
    u, u_mean = (np.sqrt((modes**2).sum(axis=-1)) for modes in (both, _mean(both)))
    mean = _mean(difference[..., None])[:, 0]
    factor = _factor(first, second, (a.degrees_of_freedom, b.degrees_of_freedom))
    return WallDifference(radii, clock, difference, u, shift, mean, u_mean, factor, judgement), evidence


def compared_radii(a: Side, b: Side, nominal_radius: float) -> Array:
    """(r,) [m], the nominal one among them: where both calibrations had points, else round the nominal one."""
    limits = [one.valid.radius for one in (a, b) if one.valid is not None and one.valid.radius is not None]
    low = max((*(limit[0] for limit in limits), (INNERMOST if limits else REACH[0]) * nominal_radius))
    high = min((limit[1] for limit in limits), default=REACH[1] * nominal_radius)
    if not low < high:
        return np.array([nominal_radius])
    return np.union1d(np.linspace(low, high, RADII), [nominal_radius])


def comparable(a: Side, b: Side) -> bool:
    """Whether both are rigs with the same kind of light."""
    if a.rig is None or b.rig is None:
        return False
    return a.rig.configuration == b.rig.configuration and len(a.rig.lasers) == len(b.rig.lasers)


def _seen(a: Rig, b: Rig, radii: Array, clock: Array) -> _Seen:
    """Of several lasers at each place the one whose radius moves least with the pixel."""
    each, sharpness = [], []
    radius = np.repeat(radii, clock.size)
    for laser in range(len(a.lasers)):
        u, v, first = on_the_wall(a, radii, clock, laser=laser)
        second = triangulate(b, u, v, laser=laser, prior_radius=radius)
        lost = np.isnan(u) | (second.status != Status.OK)
        parts = second.points, first.radius_sensitivities.parameters, second.radius_sensitivities.parameters
        each.append([np.where(lost[:, None], np.nan, part) for part in parts])
        sharpness.append(np.where(lost, np.inf, np.linalg.norm(first.radius_sensitivities.pixel, axis=1)))
    best = np.argmin(np.stack(sharpness), axis=0), np.arange(radius.size)
    points, by_a, by_b = (np.stack(part)[best] for part in zip(*each, strict=True))
    return _Seen(points, (by_a, by_b))


def _motions(slopes: Array, one: Side, names: tuple[str, ...]) -> Array:
    known = one.covariance
    columns = [names.index(name) for name in known.names]
    return slopes[:, columns] @ known.factor()


def _shift(points: Array, radius: float) -> Array:
    """(2,) [m]: the centre of the circle that fits `points` (c, 3) best."""
    seen = np.isfinite(points[:, 0])
    shift = np.zeros(2)
    if seen.sum() < FEWEST:
        return shift
    for _ in range(STEPS):
        away = points[seen, :2] - shift
        distance = np.hypot(*away.T)
        shift = shift + _centring(away / distance[:, None]) @ (distance - radius)
    return shift


def _centring(outward: Array) -> Array:
    """(2, c): from deviations along `outward` (c, 2) to the centre of a circle of free radius."""
    return np.linalg.pinv(np.column_stack([outward, np.ones(len(outward))]))[:2]


def _without_shift(modes: Array, clock: Array, *, centred: bool) -> Array:
    """The same in first order: of motions (r, c, m) [m] of the radius."""
    if not centred:
        return modes
    modes = modes.copy()
    for ring in modes:
        seen = np.isfinite(ring).all(axis=1)
        if seen.sum() >= FEWEST:
            outward = np.column_stack(xy_of(clock[seen], 1.0))
            ring[seen] -= outward @ (_centring(outward) @ ring[seen])
    return modes


def _evidence(difference: Array, linear: Array, first: Array, second: Array, freedom: tuple[float, float]) -> Evidence:
    seen = np.isfinite(difference) & np.isfinite(linear)
    return Evidence(difference[seen], linear[seen], first[seen], second[seen], freedom)


def _mean(modes: Array) -> Array:
    """(r, m) over the clocks that are seen."""
    seen = np.isfinite(modes)
    count = np.maximum(seen.sum(axis=1), 1)
    return np.where(seen.any(axis=1), np.where(seen, modes, 0.0).sum(axis=1) / count, np.nan)


def _factor(first: Array, second: Array, freedom: tuple[float, float]) -> float:
    """Of a 95 % band, degrees of freedom of both sides by Welch and Satterthwaite."""
    variances = np.array([np.nansum(modes**2) for modes in (first, second)])
    total = variances.sum()
    slack = float(((variances / total) ** 2 / np.array(freedom)).sum()) if total > 0 else 0.0
    return float(coverage_factor(degrees_of_freedom=1 / slack if slack > 0 else np.inf))

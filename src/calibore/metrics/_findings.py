"""What is found of one ring before it is given names and units: by the NumPy code, the specification of the engine."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.metrics._draws import WallGrid, regular_size, wall_grid
from calibore.metrics._shape import RingShape
from calibore.metrics._sizes import corrected_extremes, linear_sizes, second_harmonic
from calibore.metrics._wall import Wall, estimate_wall

Mask = NDArray[np.bool_]
Pair = tuple[float, float]
"""A value and its standard uncertainty."""


@dataclass(frozen=True)
class Findings:
    """Of one ring, lengths in units of `scale` [m].

    `wall`: sizes, extremes and ovalities of the estimated wall by name; `clocks` [rad from the crown of the rig] of the
    extreme diameters by name; `circle`: centre x, y and radius. `points` that count; share of `directions` with both
    ends measured; whether both ends of the `horizontal` and `vertical` diameter were; whether there is a `gap`, any
    `features`; how much more noise there is than stated, 1 if not clearly more.
    """

    scale: float
    wall: dict[str, Pair]
    clocks: dict[str, Pair]
    circle: tuple[Pair, Pair, Pair]
    points: int
    directions: float
    horizontal: bool
    vertical: bool
    gap: bool
    features: bool
    excess_noise: float


def grid_angles(size: int, roll: float) -> NDArray[np.float64]:
    """`size` regular angles over the turn [rad], then both ends of the pipe's horizontal and vertical diameter."""
    axes = np.array([0.5, 1.5, 0.0, 1.0]) * np.pi - roll
    return np.concatenate([2 * np.pi * np.arange(size) / size, axes])


def findings_by_numpy(ring: RingShape, *, roll: float) -> Findings | None:
    """None where the points do not go round one centre that the rig is inside of."""
    wall = _wall_or_none(ring)
    if wall is None:
        return None
    size = regular_size(ring.clock.size)
    grid = wall_grid(wall, ring, angles=grid_angles(size, roll), regular=size)
    both = grid.covered[: size // 2] & grid.covered[size // 2 : size]
    return Findings(
        scale=wall.scale,
        wall=linear_sizes(grid) | corrected_extremes(grid, both) | second_harmonic(grid),
        clocks={"diameter_min_clock": _clock(grid, both, -1), "diameter_max_clock": _clock(grid, both, 1)},
        circle=_circle(wall, grid),
        points=int(wall.used.sum()),
        directions=float(both.mean()),
        horizontal=bool(grid.covered[-4:-2].all()),
        vertical=bool(grid.covered[-2:].all()),
        gap=not grid.covered.all(),
        features=bool(wall.features_mask.any()),
        excess_noise=wall.excess_noise,
    )


def _wall_or_none(ring: RingShape) -> Wall | None:
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # judged below
            wall = estimate_wall(ring)
    except (InputError, np.linalg.LinAlgError):
        return None
    inside = np.hypot(*wall.centre) < 1 and 0.5 < wall.fit.coefficients[0] < 2
    return wall if inside and np.isfinite(wall.fit.coefficients).all() else None


def _circle(wall: Wall, grid: WallGrid) -> tuple[Pair, Pair, Pair]:
    variance = np.maximum(np.diag(wall.fit.covariance), 0.0)  # rounding may leave the least one negative
    common = np.sum(grid.centre_modes**2, axis=0)
    common_radius = np.sum(grid.modes[:, : grid.regular].mean(axis=1) ** 2)
    u = np.sqrt([variance[2] + common[0], variance[1] + common[1], variance[0] + common_radius])
    x, y = wall.centre
    return (float(x), float(u[0])), (float(y), float(u[1])), (float(wall.fit.coefficients[0]), float(u[2]))


def _clock(grid: WallGrid, both: Mask, sign: int) -> Pair:
    """Clock of the largest (sign 1) or smallest (-1) diameter, and how far it may be off."""
    curve, others = sign * grid.diameters("best")[0], sign * grid.diameters("possible")
    half = curve.size
    place = int(np.argmax(np.where(both, curve, -np.inf)))
    before, here, after = curve[place - 1], curve[place], curve[(place + 1) % half]
    bend = 2 * here - before - after
    peak = place + (0.5 * (after - before) / bend if bend > 0 and max(before, after) <= here else 0.0)
    away = np.mod(np.argmax(np.where(both, others, -np.inf), axis=1) - peak + half / 2, half) - half / 2
    step = np.pi / half
    return float(peak * step), float(np.sqrt(np.mean(away**2) + 1 / 12) * step)

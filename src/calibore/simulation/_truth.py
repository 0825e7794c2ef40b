"""What a perfect measurement would find: the ring on regular clocks, and the quantities of its section."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore import metrics
from calibore.geometry import Pose, clock_of, fit_circle
from calibore.rigs import Rig
from calibore.simulation._crossings import Crossings
from calibore.simulation._light import LineLight, LitLine
from calibore.simulation._parts import turned
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]
Index = NDArray[np.intp]

CLOCKS = 400
DIRECTIONS = 720
FAINTEST = 0.05  # signal from which a point counts as measurable (data README)


@dataclass(frozen=True, eq=False)
class TrueRing:
    """The wall at n regular rig clocks [rad]: `radius` [m] about the rig axis of the first wall that the laser meets,
    `axial` [m] of that point in the rig frame, whether the camera sees it lit, and the `signal` it returns. NaN where
    the light meets no wall at that clock, or leaps over it from an edge to the wall behind.
    """

    clock: Array
    radius: Array
    axial: Array
    visible: NDArray[np.bool_]
    signal: Array


@dataclass(frozen=True, eq=False)
class TrueRows:
    """What the image rows of a side-facing head show: `u` (n,) [px] of the line in each `row`, and of its wall point
    the `radius` [m], `clock` [rad] and `axial` [m] in the frame of the head; NaN where a row shows no line.
    """

    row: Array
    u: Array
    radius: Array
    clock: Array
    axial: Array
    visible: NDArray[np.bool_]
    signal: Array


def true_ring(
    lit: LitLine,
    rig: Rig,
    wall: PipeWall,
    *,
    pipe_from_rig: Pose,
    line: LineLight,
    laser: int = 0,
    clocks: int = CLOCKS,
) -> TrueRing:
    """The ring behind the line `lit`, solved exactly at `clocks` regular positions; of several points the nearest."""
    step = 2 * np.pi / clocks
    at, target = _clocks_passed(lit.clock, clocks)
    crossings = Crossings.of(lit, rig, wall, pipe_from_rig=pipe_from_rig, line=line, laser=laser)
    found = crossings.solve(at, lambda points, i: turned(clock_of(points[:, 0], points[:, 1]), target[i] * step))
    target, reach = target % clocks, np.hypot(found.points[:, 0], found.points[:, 1])
    nearest = _first_of_each(target, reach)
    radius, axial = np.full((2, clocks), np.nan)
    visible, signal = np.zeros(clocks, dtype=bool), np.zeros(clocks)
    index = target[nearest]
    radius[index], axial[index] = reach[nearest], found.points[nearest, 2]
    visible[index], signal[index] = found.visible[nearest], found.signal[nearest]
    return TrueRing(np.arange(clocks, dtype=float) * step, radius, axial, visible, signal)


def true_rows(
    lit: LitLine, rig: Rig, wall: PipeWall, *, pipe_from_rig: Pose, line: LineLight, laser: int = 0
) -> TrueRows:
    """The same for every image row, of a side-facing head at the pose `pipe_from_rig`; the visible point counts where a
    row shows several.
    """
    rows = rig.camera.height
    at, target = _rows_passed(lit.v, rows)
    crossings = Crossings.of(lit, rig, wall, pipe_from_rig=pipe_from_rig, line=line, laser=laser)
    found = crossings.solve(at, lambda points, i: rig.project(points)[1] - target[i])
    chosen = _first_of_each(target, np.where(found.visible, -found.signal, 1.0))
    points, index = found.points[chosen], target[chosen]
    u, radius, clock, axial = np.full((4, rows), np.nan)
    u[index], axial[index] = rig.project(points)[0], points[:, 2]
    radius[index], clock[index] = np.hypot(points[:, 0], points[:, 1]), clock_of(points[:, 0], points[:, 1])
    visible, signal = np.zeros(rows, dtype=bool), np.zeros(rows)
    visible[index], signal[index] = found.visible[chosen], found.signal[chosen]
    return TrueRows(np.arange(rows, dtype=float), u, radius, clock, axial, visible, signal)


def _clocks_passed(clock: Array, clocks: int) -> tuple[Index, Index]:
    """(points, targets): between each of these points of a closed line and the next is target / `clocks` of a turn."""
    unwrapped = np.unwrap(np.append(clock, clock[0])) / (2 * np.pi)
    cell = np.ceil(unwrapped * clocks).astype(np.intp)
    cell[-1] = cell[0] + clocks * round(unwrapped[-1] - unwrapped[0])
    return _passed(cell)


def _rows_passed(v: Array, rows: int) -> tuple[Index, Index]:
    """The same for the image rows 0 ... `rows` - 1 along an open line; NaN `v` reaches none."""
    at, target = _passed(np.ceil(np.clip(np.nan_to_num(v, nan=-1.0), -1.0, rows)).astype(np.intp))
    seen = (target >= 0) & (target < rows) & np.isfinite(v[at] + v[at + 1])
    return at[seen], target[seen]


def _passed(cell: Index) -> tuple[Index, Index]:
    count = np.abs(np.diff(cell))
    point = np.repeat(np.arange(count.size), count)
    nth = np.arange(point.size) - np.repeat(np.cumsum(count) - count, count)
    return point, np.minimum(cell[point], cell[point + 1]) + nth


def _first_of_each(target: Index, rank: Array) -> Index:
    """Index of the crossing with the least `rank` for every target that has one; NaN ranks last."""
    order = np.lexsort((rank, target))
    return order[np.searchsorted(target[order], np.unique(target[order]))]


def true_quantities(lit: LitLine, *, nominal_radius: float) -> dict[str, float]:
    """Quantities of the noise-free section as the rig sees it (radii across the rig axis, about the fitted centre),
    named and defined as in `calibore.metrics.RingQuantities`: means over the whole turn, extremes over directions with
    both ends visible. SI units; ovality and deflection in percent.
    """
    x, y = lit.points[:, 0], lit.points[:, 1]
    some = slice(None, None, max(x.size // DIRECTIONS, 1))
    centre = fit_circle(lit.points[some, :2], robust=True).centre
    clock, radius = clock_of(x - centre[0], y - centre[1]), np.hypot(x - centre[0], y - centre[1])
    regular = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    radii = np.interp(regular, clock, radius, period=2 * np.pi)
    seen = np.interp(regular, clock, lit.signal, period=2 * np.pi) > FAINTEST
    half = DIRECTIONS // 2
    return {
        "centre_x": float(centre[0]),
        "centre_y": float(centre[1]),
        "diameter_mean": float(2 * radii.mean()),
        "diameter_horizontal": float(radii[DIRECTIONS // 4] + radii[3 * DIRECTIONS // 4]),
        "diameter_vertical": float(radii[0] + radii[half]),
        "area": float(metrics.area(radii)),
        "perimeter": float(metrics.perimeter(radii)),
        "diameter_equivalent_area": float(metrics.diameter_equivalent_area(metrics.area(radii))),
        "ovality_harmonic": float(metrics.ovality_harmonic(radii[:half] + radii[half:])),
        **_extremes(radii[:half] + radii[half:], seen[:half] & seen[half:], nominal_radius),
    }


def _extremes(diameters: Array, both: NDArray[np.bool_], nominal_radius: float) -> dict[str, float]:
    if not both.any():
        names = (
            "diameter_min",
            "diameter_max",
            "ovality_f1216_max",
            "ovality_f1216_min",
            "ovality_range",
            "deflection",
        )
        return dict.fromkeys(names, np.nan)
    mean, least, most = diameters.mean(), diameters[both].min(), diameters[both].max()
    return {
        "diameter_min": float(least),
        "diameter_max": float(most),
        "ovality_f1216_max": float(100 * (most / mean - 1)),
        "ovality_f1216_min": float(100 * (1 - least / mean)),
        "ovality_range": float(100 * (most - least) / mean),
        "deflection": float(metrics.deflection(least, 2 * nominal_radius)),
    }

"""What a perfect measurement would find: the ring on regular clocks, and the quantities of its section."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore import metrics
from calibore.geometry import Pose, clock_of, fit_circle
from calibore.rigs import Rig
from calibore.simulation._light import LineLight, LitLine, in_view, inside_image
from calibore.simulation._parts import turned
from calibore.simulation._section import LaserPlane, wall_frame
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

CLOCKS = 400
HALVINGS = 36  # of the clock between two neighbouring points of the line: far below rounding of the radius
DIRECTIONS = 720
FAINTEST = 0.05  # signal from which a point counts as measurable (data README)


@dataclass(frozen=True, eq=False)
class TrueRing:
    """The wall at n regular rig clocks [rad]: `radius` [m] about the rig axis of the first wall that the laser meets,
    `axial` [m] of that point in the rig frame, whether the camera sees it lit, and the `signal` it returns.
    """

    clock: Array
    radius: Array
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
    """The ring behind the line `lit`, solved exactly at `clocks` regular positions; NaN where there is no wall."""
    plane, rig_from_pipe = LaserPlane.of(rig, pipe_from_rig, laser=laser), pipe_from_rig.inverse()
    step = 2 * np.pi / clocks
    point, target = _crossings(lit.clock, step)
    following = np.append(lit.pipe_clock[1:], lit.pipe_clock[0] + 2 * np.pi)
    low, high = lit.pipe_clock[point], following[point]
    rising = turned(lit.clock[point], target * step) < 0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        points = rig_from_pipe.apply(plane.section(wall, middle))
        before = (turned(clock_of(points[:, 0], points[:, 1]), target * step) < 0) == rising
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    points = rig_from_pipe.apply(plane.section(wall, low))
    nearest = _nearest(target % clocks, np.hypot(points[:, 0], points[:, 1]))
    return _ring(lit, rig, wall, plane, pipe_from_rig, line, low[nearest], (target % clocks)[nearest], clocks)


def _crossings(clock: Array, step: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(points, targets): between each of these points of a closed line and the next lies the clock target x step."""
    unwrapped = np.unwrap(np.append(clock, clock[0]))
    cell = np.ceil(unwrapped / step).astype(np.intp)
    count = np.abs(np.diff(cell))
    point = np.repeat(np.arange(clock.size), count)
    nth = np.arange(point.size) - np.repeat(np.cumsum(count) - count, count)
    return point, np.minimum(cell[point], cell[point + 1]) + nth


def _nearest(target: NDArray[np.intp], radius: Array) -> NDArray[np.intp]:
    """Index of the crossing with the least radius for every target that has one."""
    order = np.lexsort((radius, target))
    return order[np.searchsorted(target[order], np.unique(target[order]))]


def _ring(
    lit: LitLine,
    rig: Rig,
    wall: PipeWall,
    plane: LaserPlane,
    pose: Pose,
    line: LineLight,
    pipe_clock: Array,
    target: NDArray[np.intp],
    clocks: int,
) -> TrueRing:
    clock = np.arange(clocks, dtype=float) * (2 * np.pi / clocks)
    pipe_points = plane.section(wall, pipe_clock)
    points, (normal, _) = pose.inverse().apply(pipe_points), wall_frame(wall, pipe_points, pipe_clock)
    candidates = inside_image(*rig.camera.project(points), rig) & line.lights(clock[target])
    radius, axial, signal = np.full(clocks, np.nan), np.full(clocks, np.nan), np.zeros(clocks)
    visible = np.zeros(clocks, dtype=bool)
    radius[target], axial[target] = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    visible[target] = in_view(wall, plane, pose, pipe_points, normal, candidates)
    signal[target] = np.interp(pipe_clock, lit.pipe_clock, lit.signal, period=2 * np.pi)
    return TrueRing(clock, radius, axial, visible, np.where(visible, signal, 0.0))


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

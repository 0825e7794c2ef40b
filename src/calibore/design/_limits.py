"""What a rig sees: the smallest and the largest radius it measures at each clock."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._ring import predict_ring, ring_clocks
from calibore.rigs import Rig, SideFacing

Array = NDArray[np.float64]
LEAST, MOST, STEPS = 0.02, 20.0, 240  # nominal radii, on a geometric scale
CLOCKS = 72
HALVINGS = 22


@dataclass(frozen=True, eq=False)
class Limits:
    """At `clock` (c,) [rad]: the range `least` to `most` [m] about the nominal radius that is measured at first order,
    or, where the nominal radius is not, the widest range; NaN where there is none. `least` is 0 below 0.02 nominal
    radii, `most` infinite beyond 20. `everywhere` (2,) [m]: the range measured at every clock, NaN where there is none.
    `fraction` of the clocks at which the nominal radius is measured. `zenith` [rad] at the edges of the image along u,
    along v and in the corners.
    """

    clock: Array
    least: Array
    most: Array
    everywhere: tuple[float, float]
    fraction: float
    zenith: tuple[float, float, float]


def measuring_limits(
    rig: Rig, *, nominal_radius: float, assumptions: Assumptions = HONEST, clocks: int = CLOCKS
) -> Limits:
    """The limits, found on a scale of radii and then by halving to 1e-7 of the radius."""
    clock = ring_clocks(rig, clocks)
    scale = np.geomspace(LEAST, MOST, STEPS) * nominal_radius

    def measured(radius: Array) -> NDArray[np.bool_]:
        return predict_ring(rig, clock, radius, assumptions=assumptions).first_order

    seen = measured(np.broadcast_to(scale[:, None], (STEPS, clock.size)))
    first, last = np.transpose([_run(seen[:, i], scale, nominal_radius) for i in range(clock.size)])
    least = _edge(measured, first, np.maximum(first - 1, 0), scale)
    most = _edge(measured, last, np.minimum(last + 1, STEPS - 1), scale)
    none = first < 0
    least = np.where(none, np.nan, np.where(first == 0, 0.0, least))
    most = np.where(none, np.nan, np.where(last == STEPS - 1, np.inf, most))
    at_nominal = measured(np.full(clock.shape, nominal_radius))
    return Limits(clock, least, most, _everywhere(least, most), float(at_nominal.mean()), _zeniths(rig))


def _run(seen: NDArray[np.bool_], scale: Array, nominal_radius: float) -> tuple[int, int]:
    """First and last index of the run of `seen` that holds the nominal radius, else of the longest; -1, -1: none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(int)))
    if not edges.size:
        return -1, -1
    starts, ends = edges[::2], edges[1::2] - 1
    holds = np.flatnonzero((scale[starts] <= nominal_radius) & (scale[ends] >= nominal_radius))
    best = int(holds[0]) if holds.size else int(np.argmax(ends - starts))
    return int(starts[best]), int(ends[best])


def _edge(
    measured: Callable[[Array], NDArray[np.bool_]], inside: NDArray[np.intp], outside: NDArray[np.intp], scale: Array
) -> Array:
    """Between the scale's `inside` and `outside` steps, where measuring ends; the step itself at the scale's end."""
    good, bad = scale[np.maximum(inside, 0)], scale[outside]
    for _ in range(HALVINGS):
        middle = (good + bad) / 2
        seen = measured(middle)
        good, bad = np.where(seen, middle, good), np.where(seen, bad, middle)
    return good


def _everywhere(least: Array, most: Array) -> tuple[float, float]:
    if np.isnan(least).any() or np.max(least) >= np.min(most):
        return np.nan, np.nan
    return float(np.max(least)), float(np.min(most))


def _zeniths(rig: Rig) -> tuple[float, float, float]:
    """Of the nearest edge along u, of the nearest along v, of the farthest corner."""
    camera = rig.camera
    u, v = camera.principal_point
    right, down = min(u, camera.width - u), min(v, camera.height - v) / camera.aspect
    corner = np.hypot(max(u, camera.width - u), max(v, camera.height - v) / camera.aspect)
    if isinstance(rig.mount, SideFacing) and camera.height == 1:
        corner = right
    along_u, along_v, across = (float(camera.lens.zenith(np.array(reach))) for reach in (right, down, corner))
    return along_u, along_v, across

"""Readings that are not the wall where the pin points: a pin that sticks, a ball that rests on an edge beside it.

A ball of radius rho touches a wall of slope tan(a) beside its pole, under the angle a. The wall lies rho (1/cos(a) - 1)
behind the reading: more than rho where a exceeds 60 deg, and nothing that neighbours a step away can tell. So:

- deeper than what is before and behind it, one stop wide: a pit. Deeper than rho it is no pit that the ball could have
  entered and left within two steps: the pin stuck when the wall fell back. Shallower, the ball may rest on its rims;
- a slope of more than 60 deg to a deeper reading: the wall falls back somewhere between, and the shallower reading may
  be the edge touched by the ball's or the pin's side. The deeper one stands if it continues the wall on its other side;
- a step between two readings that stands out from the steps beside it, whatever its slope: an edge, as above.

What is abrupt is judged against the scatter of all second differences, which holds noise and roughness.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._tactile._neighbours import AXIAL, CLOCK, Axis, Beside, Grid, beside, moved
from calibore.status import Status

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEEPEST = np.tan(np.radians(60))
"""Slope at which the ball's correction equals its radius."""
ABRUPT = 5.0
NARROW = 3.5
"""Standard deviations of scatter by which an edge, and a pit against both its sides, is no chance: once in 10^5."""
REACH = 3.5
"""Steps of more than so many tip radii tell nothing of what the ball touches."""
ROUNDS = 5
FURTHEST = 8
"""Stops or rings that are looked at before an edge."""
AXES: tuple[Axis, Axis] = (CLOCK, AXIAL)


def scatter(radius: Array, grid: Grid, *, noise: float) -> float:
    """Standard deviation [m] of one reading about a smooth wall: noise and roughness, from second differences (n, m)
    round the rings; not less than the `noise` [m] of the probe.
    """
    before, after = (beside(radius, grid, CLOCK, side).rise for side in (-1, 1))
    bend = np.abs(before + after)
    bend = bend[np.isfinite(bend)]
    return max(noise, 1.4826 * float(np.median(bend)) / np.sqrt(6)) if bend.size else noise


def faults(radius: Array, grid: Grid, *, noise: float) -> NDArray[np.uint8]:
    """Status (n, m) of each reading [m]: OK, STUCK or OFF_TIP; where it is NaN, OK."""
    usual = scatter(radius, grid, noise=noise)
    status = np.full(radius.shape, Status.OK, dtype=np.uint8)
    for _ in range(ROUNDS):
        left = np.where(status == Status.OK, radius, np.nan)
        depth = _pit(left, grid)
        pits = depth > NARROW * np.sqrt(2) * usual
        status[pits] = np.where(depth[pits] > grid.tip_radius, Status.STUCK, Status.OFF_TIP)
        if not pits.any():
            break
    left = np.where(status == Status.OK, radius, np.nan)
    status[_steep(left, grid, usual) | _lips(left, grid, usual)] = Status.OFF_TIP
    return status


def level(rise: Array, usual: float) -> Mask:
    """Where (n, m) the reading beside differs by no more than scatter does."""
    return np.abs(rise) <= NARROW * np.sqrt(2) * usual


def _sides(radius: Array, grid: Grid, axis: Axis) -> tuple[Beside, Beside]:
    """Before and after, where steps are short enough to tell something."""
    near = np.abs(grid.apart(radius, axis, 1)) <= REACH * grid.tip_radius
    if axis == AXIAL and len(radius) > 1:
        near[-1] = near[-2]
    before, after = (beside(np.where(near, radius, np.nan), grid, axis, side) for side in (-1, 1))
    return before, after


def _pit(radius: Array, grid: Grid) -> Array:
    """By how much (n, m) [m] a reading is deeper than both beside it, along the ring or along the pipe; -inf where
    one of these is not known.
    """
    depths = [-np.maximum(*(one.rise for one in _sides(radius, grid, axis))) for axis in AXES]
    return np.max([np.where(np.isfinite(depth), depth, -np.inf) for depth in depths], axis=0)


def _steep(radius: Array, grid: Grid, usual: float) -> Mask:
    """Where the wall is steeper (n, m) than the ball can follow; a slope to a shallower reading does not count where
    the wall goes on level on the other side.
    """
    slopes = []
    for axis in AXES:
        pair = _sides(radius, grid, axis)
        found = np.zeros(radius.shape)
        for one, other in (pair, pair[::-1]):
            counts = (one.rise > 0) | ~level(other.rise, usual)
            found = np.fmax(found, np.where(counts, np.abs(one.slope), 0.0))
        slopes.append(found)
    return np.hypot(*slopes) > STEEPEST


def _lips(radius: Array, grid: Grid, usual: float) -> Mask:
    """Readings (n, m) before an abrupt fall: the last shallow one, and those before it that the ball may have touched
    the edge from, which lies at least a tip radius before the first deep one.
    """
    found = np.zeros(radius.shape, dtype=bool)
    for axis in AXES:
        pair = _sides(radius, grid, axis)
        for (one, other), side in ((pair, -1), (pair[::-1], 1)):
            falls = (one.slope > STEEPEST) | _stands_out(one, other, axis, side, usual)
            found |= falls
            away = np.abs(grid.apart(radius, axis, side))
            for steps in range(1, FURTHEST):
                found |= (moved(falls, axis, side * steps) > 0) & (steps * away < grid.tip_radius)
    return found


def _stands_out(one: Beside, other: Beside, axis: Axis, side: int, usual: float) -> Mask:
    """Where (n, m) the way down to `one` side is out of line with the ways before and after it."""
    limit = ABRUPT * np.sqrt(6) * usual
    before = np.fmax(-other.rise, 0.0)
    after = np.fmax(moved(one.rise, axis, side), 0.0)
    return (one.rise - np.nan_to_num(before) > limit) & (one.rise - np.nan_to_num(after) > limit)

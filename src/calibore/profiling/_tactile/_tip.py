"""Where the ball at the end of the pin touches, and what the wall then is where the pin points.

The wall is the envelope of the balls: it touches each of them along the normal n of the surface that their centres
make. In the frame of the pin (outwards, along clock, along the pipe) n = (1, -p, -q) / s, s = sqrt(1 + p^2 + q^2), p
and q the slopes of the readings. The touching point lies rho n from the centre; the tangent plane there meets the line
that the pin points along at reading + rho (s - 1).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._tactile._faults import STEEPEST, level
from calibore.profiling._tactile._neighbours import AXIAL, CLOCK, Axis, Beside, Grid, beside, moved

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Contact:
    """For readings (n, m): `radius` [m] of the wall where the pin points, NaN where nothing beside tells the slope, and
    its standard uncertainty from one reading to the next: `u` [m].

    The touching point: `touch_radius` [m], `touch_clock` [rad], `touch_axial` [m]; off the pin by up to the tip radius.
    """

    radius: Array
    u: Array
    touch_radius: Array
    touch_clock: Array
    touch_axial: Array


@dataclass(frozen=True, eq=False)
class _Slope:
    """Along one axis: `mean` (n, m), its standard uncertainty `u` by scatter, and on either side the slope; 0 where
    none is `known`.
    """

    mean: Array
    u: Array
    sides: tuple[Array, Array]
    known: Mask


def touch(radius: Array, grid: Grid, *, good: Mask, noise: float, usual: float) -> Contact:
    """Contacts of the `good` ones of the readings `radius` (n, m) [m]; one reading is uncertain by its `noise` [m] and
    scatters about a smooth wall by `usual` [m]. The others only say how steep the wall may be beside a good one.
    """
    along, across = (_slope(radius, grid, axis, good=good, usual=usual) for axis in (AXIAL, CLOCK))
    p, q, rho = across.mean, along.mean, grid.tip_radius
    s = np.sqrt(1 + p**2 + q**2)
    lengths = [rho * np.sqrt(1 + one**2 + other**2) for one in across.sides for other in along.sides]
    least, most = np.min(lengths, axis=0), np.max(lengths, axis=0)
    known = good & across.known & (along.known if grid.axial.size > 1 else True)
    wall = np.where(known, radius - rho + (least + most) / 2, np.nan)
    outwards, aside = radius - rho + rho / s, -rho * p / s
    away = rho * np.hypot(p, q) / s
    rough = 2 * max(usual**2 - noise**2, 0.0)
    parts = (
        noise,
        rho * np.hypot(p * across.u, q * along.u) / s,
        (most - least) / np.sqrt(12),
        np.sqrt(rough * away / np.abs(grid.apart(radius, CLOCK, 1))),
    )
    return Contact(
        radius=wall,
        u=np.sqrt(sum(np.square(part) for part in parts)) + 0 * wall,
        touch_radius=np.hypot(outwards, aside) + 0 * wall,
        touch_clock=grid.clock + np.arctan2(aside, outwards) + 0 * wall,
        touch_axial=grid.axial[:, None] - grid.travel * rho * q / s + 0 * wall,
    )


def _slope(radius: Array, grid: Grid, axis: Axis, *, good: Mask, usual: float) -> _Slope:
    """Of a wall that good neighbours tell, never across an edge steeper than the ball can follow."""
    wall = np.where(good, radius, np.nan)
    pair = [(-1, _beside_gentle(wall, grid, axis, -1)), (1, _beside_gentle(wall, grid, axis, 1))]
    slopes = np.stack([side * one.slope for side, one in pair])
    there = np.isfinite(slopes)
    count = there.sum(axis=0)
    mean = np.where(there, slopes, 0.0).sum(axis=0) / np.maximum(count, 1)
    apart = np.where(there, np.stack([one.distance for _, one in pair]), 0.0).sum(axis=0)
    u = np.sqrt(2) * usual / np.where(count > 0, apart, np.inf)
    lips = (_lip(radius, grid, axis, side=side, good=good, usual=usual) for side, _ in pair)
    sides = tuple(
        np.where(lip > 0, side * lip, np.where(known, slope, mean))
        for (side, _), lip, known, slope in zip(pair, lips, there, slopes, strict=True)
    )
    return _Slope(mean, u, (sides[0], sides[1]), count > 0)


def _lip(radius: Array, grid: Grid, axis: Axis, *, side: int, good: Mask, usual: float) -> Array:
    """Slope (n, m) down to a reading beside that is not good, where the wall does not come level from the other side:
    the ball may rest on a lip; 0 where it does not.
    """
    there, back = beside(radius, grid, axis, side), beside(radius, grid, axis, -side)
    bad = moved(np.where(good, 0.0, 1.0), axis, side) == 1
    return np.where(bad & (there.rise > 0) & ~level(back.rise, usual), np.fmin(there.slope, STEEPEST), 0.0)


def _beside_gentle(wall: Array, grid: Grid, axis: Axis, side: int) -> Beside:
    """The reading next to each, or two steps on where neither side has one; none across a steep slope."""
    near, far = (beside(wall, grid, axis, side, furthest=steps) for steps in (1, 2))
    alone = np.isnan(near.rise) & np.isnan(beside(wall, grid, axis, -side, furthest=1).rise)
    one = Beside(np.where(alone, far.rise, near.rise), np.where(alone, far.distance, near.distance))
    return Beside(np.where(np.abs(one.slope) <= STEEPEST, one.rise, np.nan), one.distance)

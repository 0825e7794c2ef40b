"""What lies beside each reading of a probe, along the ring and along the pipe."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Axis = Literal[0, 1]
CLOCK: Axis = 1
AXIAL: Axis = 0


@dataclass(frozen=True, eq=False)
class Grid:
    """Where the pin stands: `clock` (m,) [rad], a whole turn in equal steps, increasing; `axial` (n,) [m] of the rings,
    going one way; `tip_radius` [m] of the ball at the pin's end.
    """

    clock: Array
    axial: Array
    tip_radius: float

    @property
    def step(self) -> float:
        """Angle [rad] from stop to stop."""
        return 2 * np.pi / self.clock.size

    @property
    def travel(self) -> float:
        """1 where the rings follow each other along the pipe, -1 where they come back."""
        return -1.0 if self.axial[-1] < self.axial[0] else 1.0

    def apart(self, radius: Array, axis: Axis, offset: int) -> Array:
        """How far (n, m) [m] the ball's centre is from where it is `offset` stops or rings on; signed like the axis."""
        if axis == CLOCK:
            return offset * self.step * (radius - self.tip_radius)
        beyond = np.full(self.axial.size, np.nan)
        here, there = _inside(offset)
        beyond[here] = self.axial[there] - self.axial[here]
        return np.broadcast_to(beyond[:, None], radius.shape)


@dataclass(frozen=True, eq=False)
class Beside:
    """By how much the reading `before` or after differs (n, m) [m] from this one, and at what distance [m] > 0; NaN
    where there is none near.
    """

    rise: Array
    distance: Array

    @property
    def slope(self) -> Array:
        """Rise per distance (n, m), positive where the reading beside is deeper."""
        return self.rise / self.distance


def beside(radius: Array, grid: Grid, axis: Axis, side: int, *, furthest: int = 2) -> Beside:
    """The nearest reading that is not NaN, up to `furthest` steps to the `side` (-1 before, 1 after) of each."""
    rise, distance = np.full((2, *radius.shape), np.nan)
    for steps in range(furthest, 0, -1):
        there = moved(radius, axis, side * steps)
        known = np.isfinite(there)
        rise = np.where(known, there - radius, rise)
        distance = np.where(known, np.abs(grid.apart(radius, axis, side * steps)), distance)
    return Beside(rise, distance)


def moved(values: NDArray[Any], axis: Axis, offset: int) -> Array:
    """`values` (n, m) of the reading `offset` steps on, round the ring or along the pipe; NaN beyond its ends."""
    if axis == CLOCK:
        return np.roll(values, -offset, axis=1)
    found = np.full(values.shape, np.nan)
    here, there = _inside(offset)
    found[here] = values[there]
    return found


def _inside(offset: int) -> tuple[slice, slice]:
    if offset >= 0:
        return slice(None, -offset or None), slice(offset, None)
    return slice(-offset, None), slice(None, offset)

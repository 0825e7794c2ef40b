"""The clock positions of the grid: those at which the head stops."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.profiling._grid import POSITIONS
from calibore.scans import AngularMotion

Array = NDArray[np.float64]
FULL_TURN = 2 * np.pi
WHOLE = 0.05
"""A step that misses a whole number of steps in a turn by more than this part of itself divides no turn."""
FEWEST = 8
"""Fewer stops in a turn are no grid."""


@dataclass(frozen=True)
class ClockGrid:
    """`count` positions evenly round the turn, the `first` [rad] below one step."""

    first: float
    count: int

    @classmethod
    def of(cls, motion: AngularMotion) -> "ClockGrid":
        """The stops of a head whose step divides the turn, else the usual `POSITIONS` from the crown."""
        step = abs(motion.step)
        count = round(FULL_TURN / step)
        if count < FEWEST or abs(FULL_TURN - count * step) > WHOLE * step:
            return cls(0.0, POSITIONS)
        step = FULL_TURN / count
        first = float(np.mod(motion.origin, step))
        return cls(0.0 if step - first < 1e-9 else first, count)

    @property
    def step(self) -> float:
        return FULL_TURN / self.count

    @property
    def clocks(self) -> Array:
        """(count,) [rad]."""
        return np.asarray(self.first + np.arange(self.count) * self.step, dtype=np.float64)

    def nearest(self, clock: float) -> int:
        """Number of the position next to `clock` [rad]."""
        return round((clock - self.first) / self.step) % self.count

    def offset(self, clock: ArrayLike, position: int) -> Array:
        """How far `clock` (n,) [rad] lies from a position, the short way round."""
        away = np.asarray(clock, dtype=np.float64) - float(self.clocks[position])
        return np.asarray(np.mod(away + np.pi, FULL_TURN) - np.pi, dtype=np.float64)

"""All columns side by side: the grid R(axial, clock), row by row."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._grid import LAGS, Ring, local_slopes
from calibore.profiling._side._clocks import ClockGrid
from calibore.profiling._side._column import Column, empty_column
from calibore.status import has_value

Array = NDArray[np.float64]


@dataclass
class Wall:
    """The columns found so far, by clock position; rows lie at multiples of `step` [m]."""

    clocks: ClockGrid
    step: float
    columns: dict[int, Column] = field(default_factory=dict)

    def rows(self) -> Iterator[tuple[float, Ring]]:
        """Axial position [m] and ring of every row, from the first measured to the last."""
        seen = [np.flatnonzero(np.isfinite(one.radius)) + one.first for one in self.columns.values()]
        numbers = np.concatenate(seen) if seen else np.zeros(0, dtype=np.intp)
        for number in range(numbers.min(), numbers.max() + 1) if numbers.size else ():
            yield number * self.step, self._ring(number)

    @property
    def visited(self) -> float:
        """Share of the clock positions that have a column."""
        return len(self.columns) / self.clocks.count

    @property
    def axial_correlation(self) -> list[float]:
        """Correlation of the independent part with that of the row 1, 2, ... steps away, on average."""
        known = [column.correlation for column in self.columns.values()]
        return [] if not known else np.mean(known, axis=0).tolist()

    def _ring(self, number: int) -> Ring:
        """One row, moved along the wall's slope from the clocks where its points lie to those of the grid."""
        modes = len(next(iter(self.columns.values())).modes)
        nobody = empty_column(number, number + 1, modes)
        cells = [_cell(self.columns.get(position), number, nobody) for position in range(self.clocks.count)]
        radius, u, offset, status = (np.array([cell[i] for cell in cells]) for i in (0, 1, 3, 5))
        by_radius, by_clock = (np.stack([cell[i] for cell in cells], axis=1) for i in (2, 4))
        slope = local_slopes(radius[:, None], offset[:, None], self.clocks.step)
        gone = np.where(np.isfinite(radius), 0.0, np.nan)
        return Ring(
            self.clocks.clocks,
            radius - slope * np.where(has_value(status), offset, 0.0),
            gone,
            u,
            by_radius - slope * by_clock,
            status,
            np.zeros(min(LAGS, (self.clocks.count - 1) // 4)),
        )


def _cell(column: Column | None, number: int, nobody: Column) -> tuple[float, float, Array, float, Array, int]:
    """radius, u, modes, offset, turns and status of row `number`."""
    one = column if column is not None and column.first <= number < column.end else nobody
    i = number - one.first
    return one.radius[i], one.u[i], one.modes[:, i], one.offset[i], one.turns[:, i], one.status[i]

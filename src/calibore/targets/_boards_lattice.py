"""How a board's marks follow each other in the picture: steps from mark to mark and how these bend."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.targets._boards import Board

Array = NDArray[np.float64]


class Lattice(NamedTuple):
    """Steps (n, 2) [px] of the image per square `along` a row and `down` the rows, and their second derivatives
    `along_bend`, `down_bend` (n, 2) [px]; NaN where neighbours are missing. Bends that nobody tells are 0.
    """

    along: Array
    down: Array
    along_bend: Array
    down_bend: Array

    @property
    def spacing(self) -> Array:
        """The shorter step (n,) [px], as far as known."""
        lengths = np.stack([np.linalg.norm(self.along, axis=1), np.linalg.norm(self.down, axis=1)])
        return np.fmin(*lengths)


def lattice_of(marks: Array, board: Board) -> Lattice:
    """From the places `marks` (n, 2) [px] of all marks of `board`, NaN where not seen; square grids only."""
    grid = marks.reshape(board.corners[1], board.corners[0], 2)
    along, along_bend = _derivatives(grid)
    down, down_bend = (part.transpose(1, 0, 2) for part in _derivatives(grid.transpose(1, 0, 2)))
    return Lattice(*(part.reshape(-1, 2) for part in (along, down, along_bend, down_bend)))


def _derivatives(grid: Array) -> tuple[Array, Array]:
    """First and second derivative (r, c, 2) along the second axis."""
    padded = np.pad(grid, ((0, 0), (1, 1), (0, 0)), constant_values=np.nan)
    before, after = grid - padded[:, :-2], padded[:, 2:] - grid
    bend = _filled(after - before)
    both = (before + after) / 2
    one_sided = np.where(np.isfinite(after), after - bend / 2, before + bend / 2)
    return np.where(np.isfinite(both), both, one_sided), bend


def _filled(bend: Array) -> Array:
    """Gaps continue the next two of their row evenly, or take the value of the next one; 0 where a row has none."""
    filled = bend.copy()
    for even in (True, False):
        for step in (1, -1):
            first, second = _shifted(bend, step), _shifted(bend, 2 * step)
            filled = np.where(np.isfinite(filled), filled, 2 * first - second if even else first)
    return np.where(np.isfinite(filled), filled, 0.0)


def _shifted(bend: Array, step: int) -> Array:
    """The value of the neighbour `step` before, NaN where there is none."""
    shifted = np.roll(bend, step, axis=1)
    shifted[:, slice(None, step) if step > 0 else slice(step, None)] = np.nan
    return shifted

"""Where the neighbours of each ray say that the line is, as `native/src/stripe/neighbours.rs`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._noise import NORMAL
from calibore.stripe._pieces import FEWEST, PIECES, pieces, smoothed

Array = NDArray[np.float64]
FEWEST_BESIDE, LARGEST_PART = 4, 16
"""Neighbours on each side are at least so many rays, at most one in so many of all."""
ASTRAY = 3.0
"""Places further from their neighbours than this many standard deviations belong to no straight piece of line."""
MEAN = 1.2533
"""Standard deviation of a normal distribution over its mean absolute deviation."""
CALM = 0.75
"""Share of the rays near a place that must belong to a straight piece of line for them to say where it is."""


@dataclass(frozen=True)
class Standpoint:
    """Where n rays are looked at from: `start` (n,) [px], NaN where there is no peak, or none but a plateau; the usual
    `height` (n,) of the line there; `calm` (n,): its neighbours say where it is, elsewhere it says so itself; `rough`:
    standard deviation of places about their neighbours [px].
    """

    start: Array
    height: Array
    calm: NDArray[np.bool_]
    rough: float


def standpoints(position: Array, height: Array, *, within: float, spacing: float, closed: bool) -> Standpoint:
    """From `position`, `height` (n,) of the peaks of rays `spacing` [px] apart and which are `saturated` (n,), by
    straight lines through those `within` [px] of each.
    """
    reach = reach_of(position.size, within, spacing)
    seen = np.isfinite(position)
    astray = np.abs(position - _Near(seen, reach, closed).line(position))
    rough = NORMAL * float(np.median(astray[seen]))
    limit = ASTRAY * _rough_here(astray, seen, rough, closed)
    straight = seen & (astray <= limit)
    near = _Near(straight, reach, closed)
    guide = near.line(position)
    calm = straight & (np.abs(position - guide) <= limit) & (near.count >= CALM * (2 * reach + 1))
    known = _Near(seen, reach, closed)
    return Standpoint(np.where(calm, guide, position), known.mean(height), calm, rough)


def reach_of(count: int, within: float, spacing: float) -> int:
    """Neighbours on each side of a ray, of `count` rays `spacing` [px] apart, that lie `within` [px] of it."""
    return int(np.clip(np.ceil(within / spacing), FEWEST_BESIDE, max(FEWEST_BESIDE, count // LARGEST_PART)))


def _rough_here(astray: Array, seen: NDArray[np.bool_], rough: float, closed: bool) -> Array:
    """Standard deviation (n,) of places about their neighbours on the piece of line that each ray lies on, `rough` at
    least, which is that of all: a line that is wider somewhere, or fainter, is noisier there.
    """
    piece = pieces(astray.size)
    count = np.bincount(piece[seen], minlength=PIECES)
    total = np.bincount(piece[seen], np.minimum(astray[seen], ASTRAY * rough), minlength=PIECES)
    told = np.divide(MEAN * total, count, out=np.full(PIECES, rough), where=count >= FEWEST)
    return np.maximum(smoothed(told, closed=closed), rough)[piece]


class _Near:
    """The rays within `reach` of each of n, those that `counts` (n,)."""

    def __init__(self, counts: NDArray[np.bool_], reach: int, closed: bool) -> None:
        self._counts, self._reach, self._mode = counts, reach, "wrap" if closed else "constant"
        self._lever = np.arange(-reach, reach + 1, dtype=np.float64)
        self._share = self._windows(counts.astype(np.float64))
        self.count = self._share.sum(axis=1)

    def _windows(self, values: Array) -> Array:
        padded = np.pad(values, self._reach, mode=self._mode)  # pyright: ignore[reportCallIssue, reportArgumentType]
        return np.lib.stride_tricks.sliding_window_view(padded, 2 * self._reach + 1)

    def mean(self, values: Array) -> Array:
        """Mean (n,) of `values` (n,); 0 where none counts."""
        return self._windows(np.where(self._counts, values, 0.0)).sum(axis=1) / np.maximum(self.count, 1.0)

    def line(self, values: Array) -> Array:
        """Value (n,) at each ray of the straight line through those about it; infinite where there are too few."""
        first = values[self._counts][:1].sum()
        value = self._windows(np.where(self._counts, values - first, 0.0))
        turn, square = self._share @ self._lever, self._share @ self._lever**2
        determinant = self.count * square - turn**2
        above = square * value.sum(axis=1) - turn * (value @ self._lever)
        return first + np.divide(above, determinant, out=np.full(len(values), np.inf), where=determinant > 0)

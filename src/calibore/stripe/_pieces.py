"""What differs along the line, told piece by piece, as `native/src/stripe/pieces.rs`."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PIECES = 16
"""Of a whole ring or line."""
FEWEST = 8
"""Rays that tell something of a piece."""


def pieces(count: int) -> NDArray[np.intp]:
    """Number (count,) of the piece that each of so many rays lies on."""
    return np.arange(count) * PIECES // count


def bridged(values: Array, *, closed: bool) -> Array:
    """`values` (PIECES,), those that are NaN from the pieces on both sides; all NaN where fewer than half are known."""
    known, at = np.isfinite(values), np.arange(PIECES)
    if 2 * np.count_nonzero(known) < PIECES:
        return np.full(PIECES, np.nan)
    return np.interp(at, at[known], values[known], period=PIECES if closed else None)


def smoothed(values: Array, *, closed: bool) -> Array:
    """Each of `values` (PIECES,) with half the mean of those on both sides."""
    beside = np.pad(values, 1, mode="wrap" if closed else "edge")
    return 0.25 * beside[:-2] + 0.5 * values + 0.25 * beside[2:]


def along(values: Array, count: int, *, closed: bool) -> Array:
    """`values` (PIECES,) of the middles of the pieces at so many rays (count,)."""
    place = (np.arange(count) + 0.5) * PIECES / count - 0.5
    return np.interp(place, np.arange(PIECES), values, period=PIECES if closed else None)

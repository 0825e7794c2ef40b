"""The line of a ring smoothed along itself, and how noisy it is here and there."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.stripe import Stripe

Array = NDArray[np.float64]
REACH = 10
"""Rays on each side over which the line is smoothed: four times the reach of the noise that neighbours share."""
LAG = 8
"""Least number of rays between peaks compared for their scatter."""
SECOND_DIFFERENCE = 1.5
"""Variance of p_i - (p_i-k + p_i+k) / 2 over that of independent p."""
NOISE = 3.5
"""Standard uncertainties beyond which a difference is no noise but an edge."""
MEDIAN_OF_SQUARE, MEAN_OF_SQUARE = 0.4549, 0.9939
"""Of the square of a standard normal z: its median, and its mean where |z| is below `NOISE`."""
SECTOR = 90
"""Rays on each side whose scatter gives the local noise."""
SECTORS = 50
"""Places round the ring at which the local noise is told."""
FEWEST = 40
"""Peaks needed for a scatter."""
STEP = 4
"""Rays that a clock position averages, roughly."""


class SmoothedLine(NamedTuple):
    """A line smoothed along itself: `u`, `v` (n,) [px], NaN where the ray has no peak; `off` (n,) [px] the peaks'
    distance from it along their rays; `noise` (n,) [px] standard uncertainty of the peaks; `smaller`: that of the
    smoothed line over it.
    """

    u: Array
    v: Array
    off: Array
    noise: Array
    smaller: float


def smoothed_line(stripe: Stripe) -> SmoothedLine:
    """`stripe`, closed round a ring: each peak the median of its neighbours, moved to it along the line's local slope.

    A median keeps edges, and what is wider than `REACH` rays.
    """
    column, row = stripe.centre or (0.0, 0.0)
    direction = stripe.direction
    position = (stripe.u - column) * direction[:, 0] + (stripe.v - row) * direction[:, 1]
    near = position[_around(position.size)]
    slope = _medians((near[:, 2:] - near[:, :-2]) / 2)
    middle = _medians(near - slope[:, None] * np.arange(-REACH, REACH + 1))
    middle = np.where(np.isfinite(position), middle, np.nan)
    lag = max(LAG, stripe.correlation.size + 1)
    noise = stripe.u_position * local_scatter(position, stripe.u_position, lag=lag)
    u, v = column + middle * direction[:, 0], row + middle * direction[:, 1]
    return SmoothedLine(u, v, position - middle, noise, _smaller(stripe.correlation))


def _around(count: int) -> NDArray[np.intp]:
    """(count, 2 REACH + 1) the rays round each ray."""
    return (np.arange(count)[:, None] + np.arange(-REACH, REACH + 1)) % count


def _medians(rows: Array) -> Array:
    """(n,) median of the finite values of each row (n, k); 0 where there is none."""
    rows = np.sort(rows, axis=1)
    known = np.isfinite(rows).sum(axis=1)
    index = np.arange(len(rows))
    middle = 0.5 * (rows[index, np.maximum(known - 1, 0) // 2] + rows[index, np.minimum(known // 2, known.max() - 1)])
    return np.where(known > 0, middle, 0.0)


def local_scatter(position: Array, u: Array, *, lag: int) -> Array:
    """(n,) observed over stated scatter round a ring, of `position` with standard uncertainty `u` (n,) [px].

    A cone's light falls at another angle on every side of the wall: its line is up to three times as wide on one side
    as on the other, and so is the noise of its speckle, which the noise of a picture as a whole does not tell. From
    second differences at `lag`, as the stripe's own scale is; those across an edge do not count.
    """
    count = position.size
    bend = position - 0.5 * (np.roll(position, lag) + np.roll(position, -lag))
    square = bend**2 / (SECOND_DIFFERENCE * u**2)
    places = np.linspace(0, count, SECTORS, endpoint=False).astype(np.intp)
    sectors = square[(places[:, None] + np.arange(-SECTOR, SECTOR + 1)) % count]
    kept = sectors <= NOISE**2 * _medians(sectors)[:, None] / MEDIAN_OF_SQUARE
    known = kept.sum(axis=1)
    mean = np.sum(np.where(kept, sectors, 0.0), axis=1) / np.maximum(known, 1) / MEAN_OF_SQUARE
    local = np.where((known >= FEWEST) & (mean > 0), np.sqrt(mean), 1.0)
    return np.interp(np.arange(count), places, local, period=count)


def _smaller(correlation: Array) -> float:
    """Standard uncertainty of the running median over that of one peak: var = sum arcsin(correlation) / count^2.

    As the grid takes it: it averages the rays of a step as if only `correlation` tied them, but smoothed ones are one.
    """
    shared = np.concatenate([[1.0], correlation, np.zeros(2 * REACH + 1)])

    def pairs(count: int) -> NDArray[np.intp]:
        index = np.arange(count)
        return np.abs(index[:, None] - index)

    median = np.arcsin(shared[pairs(2 * REACH + 1)]).mean()
    return float(np.sqrt(median / shared[pairs(STEP)].mean()))

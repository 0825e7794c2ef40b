"""The scatter of a line freed of what features of the wall add to it.

A median is robust, not blind: where a sixth of the rays lies on edges, dents and bevels, the median of squared second
differences is a fifth too large, as if the whole line were noisier. Here differences beyond `CUT` standard deviations
are left out instead, and the mean of the rest is corrected for what a normal distribution loses by that. It applies to
the scale of all uncertainties and to the correlation of neighbouring points alike. The compiled kernel does the same
in `native/src/stripe/{scatter,features}.rs`.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._scatter import FEWEST, NORMAL_HALF, SECOND_DIFFERENCE, correlation_of
from calibore.stripe._stripe import Stripe

Array = NDArray[np.float64]
CUT = 2.5
"""Standard deviations from which a difference counts as a feature: nearer, edges are kept; farther, noise is lost."""
KEPT = 0.911255
"""Mean square of a standard normal z where |z| < CUT: 1 - 2 CUT density(CUT) / (2 probability(CUT) - 1)."""
ROUNDS = 12
"""Of cutting and averaging, each on the result of the one before, at most."""


def freed_of_features(stripe: Stripe) -> Stripe:
    """`stripe` with `u_position`, `scale` and `correlation` from differences that are noise; unchanged where its own
    scatter told nothing, or where too few differences are left.
    """
    far = stripe.correlation.size + 1
    if far == 1:
        return stripe
    column, row = stripe.centre or (0.0, 0.0)
    position = (stripe.u - column) * stripe.direction[:, 0] + (stripe.v - row) * stripe.direction[:, 1]
    ratio = _mean_squares(_squares(position, stripe.u_position, far + 2, closed=stripe.centre is not None))
    total = float(np.median(ratio[far - 1 :])) / SECOND_DIFFERENCE
    if not 0 < total < np.inf:
        return stripe
    size, correlation = float(np.sqrt(total)), correlation_of(ratio, total, far=far)
    return replace(stripe, u_position=stripe.u_position * size, scale=stripe.scale * size, correlation=correlation)


def _squares(position: Array, u: Array, most: int, *, closed: bool) -> Array:
    """(most, n) squared second differences at lags 1 ... `most` over the variance of their middle, NaN where none."""
    count, beyond = position.size, np.full(most, np.nan)

    def extended(values: Array) -> Array:
        return np.concatenate([values[-most:], values, values[:most]] if closed else [beyond, values, beyond])

    places, variances = extended(position), extended(u * u / 4)
    squares = np.empty((most, count))
    for lag in range(1, most + 1):
        before, after = slice(most - lag, most - lag + count), slice(most + lag, most + lag + count)
        bend = position - 0.5 * (places[before] + places[after])
        with np.errstate(divide="ignore", invalid="ignore"):  # a peak without uncertainty says nothing of the others
            squares[lag - 1] = bend * bend / (u * u + variances[before] + variances[after])
    return SECOND_DIFFERENCE * squares


def _mean_squares(squares: Array) -> Array:
    """(m,) of the rows of `squares` (m, n), features left out; NaN where there are fewer than `FEWEST`."""
    mean = np.full(len(squares), np.nan)
    for number, row in enumerate(squares):
        known = row[np.isfinite(row)]
        if known.size < FEWEST:
            continue
        known.sort()
        sums, size = np.cumsum(known), known[known.size // 2] / NORMAL_HALF**2
        kept = 0
        for _ in range(ROUNDS):
            before, kept = kept, int(known.searchsorted(CUT**2 * size))
            if kept in (0, before):
                break
            size = sums[kept - 1] / kept / KEPT
        mean[number] = size
    return mean

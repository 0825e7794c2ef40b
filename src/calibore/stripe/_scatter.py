"""What the line itself says about its noise: the scatter of neighbouring peaks.

The model uncertainty of each peak is scaled so that it explains the scatter of the peaks about a straight line through
their neighbours (a Birge ratio), taken over distances at which the noise has forgotten itself; at shorter distances the
same differences tell how much neighbouring peaks share. Robust, so that edges and features do not count.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
NORMAL_HALF = 0.6745
"""Median of |z| for a standard normal z."""
FORGOTTEN = 6.0
"""Noise is independent beyond this many line widths along the line (grain and blur are narrower than the line)."""
FEWEST = 40
"""Second differences needed for a scatter."""
SECOND_DIFFERENCE = 1.5
"""Variance of p_i - (p_i-k + p_i+k) / 2 over that of independent p."""
HIGHEST = 0.99
"""Correlation of neighbours is kept below this."""


@dataclass(frozen=True)
class Scatter:
    """`scale`: observed over modelled standard uncertainty; `correlation` (k,) of neighbouring peaks at lags 1 .. k."""

    scale: float
    correlation: Array


def neighbour_scatter(position: Array, *, width: float, spacing: float) -> float:
    """Robust scatter [px] of `position` (n,) about its neighbours just beyond the reach of the noise correlation."""
    lag = max(1, int(np.ceil(FORGOTTEN * width / spacing)))
    ratio = scatter_ratio(position, np.ones_like(position), lag, closed=False)
    return float(np.sqrt(ratio / SECOND_DIFFERENCE)) if np.isfinite(ratio) else np.inf


def observe_scatter(position: Array, u: Array, *, width: float, spacing: float, closed: bool) -> Scatter:
    """Scatter of `position` (n,) [px] with modelled standard uncertainty `u` (n,) [px]; NaN where there is no peak."""
    far = int(np.clip(np.ceil(FORGOTTEN * width / spacing), 3, max(3, len(position) // 16)))
    ratio = np.array([scatter_ratio(position, u, lag, closed=closed) for lag in range(1, far + 3)])
    total = float(np.nanmedian(ratio[far - 1 :])) / SECOND_DIFFERENCE if np.isfinite(ratio[far - 1]) else 0.0
    if total == 0:  # too few peaks, or places in whole samples: no evidence against the model
        return Scatter(1.0, np.zeros(0))
    return Scatter(float(np.sqrt(total)), correlation_of(ratio, total, far=far))


def correlation_of(ratio: Array, total: float, *, far: int) -> Array:
    """(far - 1,) of neighbouring peaks at lags 1 ..., from the mean squares `ratio` of second differences at those."""
    correlation = np.zeros(2 * far + 1)
    for lag in range(far - 1, 0, -1):
        # var(p_i - (p_i-k + p_i+k) / 2) = (1.5 - 2 rho_k + rho_2k / 2) sigma^2
        seen = ratio[lag - 1] / total if np.isfinite(ratio[lag - 1]) else SECOND_DIFFERENCE
        correlation[lag] = min(max((SECOND_DIFFERENCE + 0.5 * correlation[2 * lag] - seen) / 2, 0.0), HIGHEST)
    return correlation[1:far]


def scatter_ratio(position: Array, u: Array, lag: int, *, closed: bool) -> float:
    """Robust mean square of second differences at `lag` over the variance of their middle; NaN if too few."""
    before, after = np.roll(position, lag), np.roll(position, -lag)
    square = u**2 + 0.25 * (np.roll(u, lag) ** 2 + np.roll(u, -lag) ** 2)
    z = SECOND_DIFFERENCE * (position - 0.5 * (before + after)) ** 2 / square
    z = z if closed else z[lag:-lag]
    z = z[np.isfinite(z)]
    return float(np.median(z) / NORMAL_HALF**2) if z.size >= FEWEST else np.nan

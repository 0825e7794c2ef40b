"""What the line itself says about its noise: the scatter of neighbouring peaks.

The model uncertainty of each peak is scaled so that it explains the scatter of the peaks about a straight line through
their neighbours (a Birge ratio), taken over distances at which the noise has forgotten itself; at shorter distances the
same differences tell how much neighbouring peaks share. Robust, so that edges and features do not count.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
NORMAL_HALF = 0.6745
"""Median of |z| for a standard normal z."""
FORGOTTEN = 6.0
"""Noise is independent beyond this many line widths along the line (grain and blur are narrower than the line)."""
FEWEST = 40


@dataclass(frozen=True)
class Scatter:
    """`scale`: observed over modelled standard uncertainty; `correlation` (k,) of neighbouring peaks at lags 1 .. k."""

    scale: float
    correlation: Array


Ratios = Callable[[Array, Array, Sequence[int], bool], Sequence[float]]
"""`scatter_ratios` or its compiled form."""


def neighbour_scatter(position: Array, *, width: float, spacing: float, ratios: Ratios) -> float:
    """Robust scatter [px] of `position` (n,) about its neighbours just beyond the reach of the noise correlation."""
    lag = max(1, int(np.ceil(FORGOTTEN * width / spacing)))
    return float(np.sqrt(ratios(position, np.ones_like(position), [lag], False)[0] / 1.5))


def observe_scatter(
    position: Array, u: Array, *, width: float, spacing: float, closed: bool, ratios: Ratios
) -> Scatter:
    """Scatter of `position` (n,) [px] with modelled standard uncertainty `u` (n,) [px]; NaN where there is no peak."""
    far = int(np.clip(np.ceil(FORGOTTEN * width / spacing), 3, max(3, len(position) // 16)))
    ratio = np.asarray(ratios(position, u, list(range(1, far + 3)), closed))
    if not np.isfinite(ratio[far - 1]):
        return Scatter(1.0, np.zeros(0))
    total = float(np.nanmedian(ratio[far - 1 :])) / 1.5
    correlation = np.zeros(2 * far + 1)
    for lag in range(far - 1, 0, -1):
        # var(p_i - (p_i-k + p_i+k)/2) = (1.5 - 2 rho_k + rho_2k / 2) sigma^2
        seen = ratio[lag - 1] / total if np.isfinite(ratio[lag - 1]) else 1.5
        correlation[lag] = min(max((1.5 + 0.5 * correlation[2 * lag] - seen) / 2, 0.0), 0.99)
    return Scatter(float(np.sqrt(total)), correlation[1:far])


def scatter_ratios(position: Array, u: Array, lags: Sequence[int], closed: bool) -> list[float]:
    """`scatter_ratio` at every lag: the twin of `native/src/stripe/scatter.rs`."""
    return [scatter_ratio(position, u, lag, closed=closed) for lag in lags]


def scatter_ratio(position: Array, u: Array, lag: int, *, closed: bool) -> float:
    """Robust mean square of second differences at `lag` over the squared uncertainty of their middle; NaN if too few."""
    before, after = np.roll(position, lag), np.roll(position, -lag)
    square = (u**2 + 0.25 * np.roll(u, lag) ** 2 + 0.25 * np.roll(u, -lag) ** 2) / 1.5
    z = np.abs(position - 0.5 * (before + after)) / np.sqrt(square)
    z = z if closed else z[lag:-lag]
    z = z[np.isfinite(z)]
    return float((np.median(z) / NORMAL_HALF) ** 2) if z.size >= FEWEST else np.nan

"""How large the largest deviation of an unchanged pipe would be by chance."""

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._smoothing import Smoother, Window

Array = NDArray[np.float64]

MAPS = 200
"""Unchanged maps that are drawn."""
ALIKE = 31
"""Clock positions over which what is missed between points is alike."""
EULER = 0.5772156649
"""Mean of the standard Gumbel distribution."""


def threshold(
    smoother: Smoother, windows: tuple[Window, ...], *, false_alarm: float, rng: np.random.Generator
) -> float:
    """Standard uncertainties that the greatest mean over any window, anywhere, exceeds with probability `false_alarm`
    though nothing has changed.

    Maxima of drawn maps, with noise and common errors as in the difference, follow Gumbel's distribution (Gumbel 1958);
    its quantile is steadier than theirs.
    """
    largest = np.array([_largest(smoother, windows, rng) for _ in range(MAPS)])
    spread = np.sqrt(6) / np.pi * largest.std(ddof=1)
    return float(largest.mean() - EULER * spread - spread * np.log(-np.log1p(-false_alarm)))


def _largest(smoother: Smoother, windows: tuple[Window, ...], rng: np.random.Generator) -> float:
    field = _noise(smoother, rng) + _missed(smoother, rng)
    field = field + np.tensordot(rng.normal(size=len(smoother.modes)), smoother.modes, axes=1)
    return max(float(np.nanmax(np.abs(smoother.mean(field, one)) / smoother.u(one))) for one in windows)


def _missed(smoother: Smoother, rng: np.random.Generator) -> Array:
    """(n, m) what lies between points, of one sign over a stretch of wall."""
    n, m = smoother.missed.shape
    pieces = max(m // ALIKE, 1)
    return smoother.missed * np.repeat(rng.normal(size=(n, pieces)), -(-m // pieces), axis=1)[:, :m]


def _noise(smoother: Smoother, rng: np.random.Generator) -> Array:
    """(n, m) of the stated variance, correlated along the clock."""
    n, m = smoother.variance.shape
    row = np.zeros(m)
    row[0] = 1.0
    lags = np.arange(1, min(smoother.correlation.size, m // 2 - 1) + 1)
    row[lags] = row[-lags] = smoother.correlation[: lags.size]
    power = np.maximum(np.fft.rfft(row).real, 0.0)
    white = np.fft.rfft(rng.normal(size=(n, m)), axis=1)
    noise = np.fft.irfft(white * np.sqrt(power), n=m, axis=1)
    return noise * np.sqrt(np.nan_to_num(smoother.variance))

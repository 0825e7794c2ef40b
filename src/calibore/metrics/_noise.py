"""The independent part of the noise: its own size at every point, correlated over a few clock steps."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SEED = 1216
PAIRS = 64
LEAST_SPECTRUM = 0.02
"""Of white noise: what is left at the frequency where neighbours cancel most."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard uncertainty (n,) of all clock positions and autocorrelation (k,) at lags 1..k clock steps.

    Correlations that were estimated lag by lag, and cut off, may be those of no noise at all (a negative spectrum):
    they are shrunk until there is one that has them.
    """

    sigma: Array
    correlation: Array

    def __post_init__(self) -> None:
        table = np.zeros(self.sigma.size)
        table[0], lags = 1.0, self.correlation[: (table.size - 1) // 2]
        table[1 : lags.size + 1] = lags
        table[table.size - lags.size :] = lags[::-1]
        least = float(np.fft.rfft(table).real.min())
        if least < LEAST_SPECTRUM:
            shrunk = self.correlation * (1 - LEAST_SPECTRUM) / (1 - least)
            object.__setattr__(self, "correlation", shrunk)

    def covariance_of(self, functionals: Array) -> Array:
        """Covariance (p, p) of the linear functionals (n, p) of the radii."""
        scaled = functionals * self.sigma[:, None]
        covariance = scaled.T @ scaled
        if self.correlation.size:
            ahead = np.zeros_like(scaled)
            for lag, rho in enumerate(self.correlation, start=1):
                ahead[:-lag] += rho * scaled[lag:]
                ahead[-lag:] += rho * scaled[:lag]
            lagged = scaled.T @ ahead
            covariance += lagged + lagged.T
        return covariance

    def block(self, index: NDArray[np.intp]) -> Array:
        """Covariance (q, q) of the points `index` (q,)."""
        n = self.sigma.size
        steps = np.abs(index[:, None] - index[None, :])
        table = np.zeros(n)
        table[: self.correlation.size + 1] = np.concatenate([[1.0], self.correlation])
        return table[np.minimum(steps, n - steps)] * np.outer(self.sigma[index], self.sigma[index])

    def sum_variance(self, width: int) -> float:
        """Variance of the sum of `width` neighbours in units of sigma^2."""
        lags = np.arange(1, min(width, self.correlation.size + 1))
        return max(float(width + 2 * ((width - lags) * self.correlation[: lags.size]).sum()), 0.5 * width)


@lru_cache(maxsize=8)
def orthonormal_draws(size: int) -> Array:
    """(2 q, size) fixed standard normal draws, q >= 64, made antithetic and exactly uncorrelated.

    Means and covariances of linear functions of them are exact; only curvature is sampled.
    """
    pairs = PAIRS
    while pairs < size:
        pairs *= 2
    draws = np.random.default_rng(SEED).standard_normal((pairs, size))
    draws = np.linalg.qr(draws)[0] * np.sqrt(pairs)
    return np.concatenate([draws, -draws])


@lru_cache(maxsize=64)
def plain_draws(rows: int, size: int) -> Array:
    """(rows, size) fixed antithetic standard normal draws with unit sample variance."""
    if size == 0:
        return np.zeros((rows, 0))
    draws = np.random.default_rng(SEED + 1).standard_normal((rows // 2, size))
    draws /= np.sqrt(np.mean(draws**2, axis=0))
    return np.concatenate([draws, -draws])


def inverse(matrix: Array) -> Array:
    return np.linalg.inv(matrix).astype(np.float64, copy=False)


def factor(covariance: Array) -> Array:
    """A lower factor L with L L^T = covariance, for one that is positive up to rounding."""
    scale = np.trace(covariance) / len(covariance)
    for jitter in (0.0, 1e-13, 1e-10, 1e-7):
        try:
            return np.linalg.cholesky(covariance + jitter * scale * np.eye(len(covariance)))
        except np.linalg.LinAlgError:
            continue
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0.0))

"""Residuals of neighbours are alike: how much, and what that does to the information in them."""

import numpy as np
from numpy.typing import NDArray

from calibore.registration._gaps import Cloud

Array = NDArray[np.float64]

LAGS = 24
"""Clock positions up to which residuals are compared; weighted down towards the end (Parzen)."""
ALIKE = 31
"""Clock positions over which what is missed between rings is alike."""
RINGS = 3
"""Rings up to which they are."""


def design_effect(relative: Array, weights: Array, cloud: Cloud) -> tuple[Array, float]:
    """Correlation (LAGS,) of residuals along the clock, tapered, and the factor by which those of neighbouring rings
    enlarge the variance; `relative` (p,) residuals of unit variance, NaN where there is none.
    """
    grid = _grid(np.where(weights > 0, relative * np.sqrt(weights), 0.0)[:, None], cloud)[..., 0]
    used = _grid((weights > 0).astype(float)[:, None], cloud)[..., 0]
    mean = grid.sum() / max(used.sum(), 1.0)
    grid = np.where(used > 0, grid - mean, 0.0)
    variance = np.sum(grid**2) / max(used.sum(), 1.0)
    if variance <= 0:
        return np.zeros(LAGS), 1.0
    along = np.array([_shared(grid, np.roll(grid, -k, 1), used, np.roll(used, -k, 1)) for k in range(1, LAGS + 1)])
    rows = [_shared(grid[k:], grid[:-k], used[k:], used[:-k]) for k in range(1, RINGS + 1) if grid.shape[0] > k]
    taper = 1 - np.arange(1, LAGS + 1) / (LAGS + 1)
    return np.clip(along / variance, -1, 1) * taper, 1 + 2 * float(np.sum(np.maximum(rows, 0.0)) / variance)


def _shared(one: Array, other: Array, used: Array, also: Array) -> float:
    return float(np.sum(one * other) / max(np.sum(used * also), 1.0))


def scores_covariance(rows: Array, cloud: Cloud, correlation: Array, missed: Array) -> Array:
    """(s, s) covariance of the sum of scores: `rows` (p, s) times residuals of unit variance, correlated with the k-th
    neighbour along the clock by `correlation` (k,). Of each, `missed` (p,) is what lies between points: a flank does
    between two rings what it does over a stretch of clock positions.
    """
    total = rows.T @ rows
    grid = _grid(rows, cloud)
    hidden = _grid(rows * missed[:, None], cloud)
    beside = np.add.reduceat(hidden, np.arange(0, cloud.positions, ALIKE), axis=1)
    total = total + np.tensordot(beside, beside, axes=([0, 1], [0, 1])) - np.tensordot(hidden, hidden, ([0, 1], [0, 1]))
    for k, shared in enumerate(correlation.tolist(), start=1):
        part = np.tensordot(grid, np.roll(grid, -k, 1), axes=([0, 1], [0, 1]))
        total = total + shared * (part + part.T)
    return total


def _grid(values: Array, cloud: Cloud) -> Array:
    """`values` (p, s) where they stand among the moving profile's rings and clock positions, 0 elsewhere."""
    grid = np.zeros((int(cloud.ring.max()) + 1, cloud.positions, values.shape[1]))
    grid[cloud.ring, cloud.position] = values
    return grid

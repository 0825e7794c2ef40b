"""Several measurements of one quantity made one: weights of least variance, what they share counted once."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ALIKE = 1e-12  # added to the diagonal of correlations: measurements that share everything get equal weights


def least_variance_weights(independent: Array, modes: Array, usable: NDArray[np.bool_] | None = None) -> Array:
    """Weights (l, ...), not negative and with sum 1, of l measurements: standard uncertainties `independent` (l, ...)
    and common `modes` (l, m, ...): their covariance is diag(independent^2) + modes . modes.

    V^-1 1 / (1' V^-1 1) over those that are `usable` (l, ...); 0 for the others, and everywhere 0 where none is. A
    weight that would be negative (a measurement that only tells of the common errors of a better one) is 0 instead:
    such a difference of nearly equal numbers rests on a covariance that nobody knows so well.
    """
    usable = np.isfinite(independent) if usable is None else usable
    here = np.moveaxis(usable, 0, -1)
    noise = np.moveaxis(np.where(usable, independent, 0.0), 0, -1)
    shared = np.where(usable[:, None], modes, 0.0)
    covariance = np.einsum("im...,jm...->...ij", shared, shared)
    each = np.arange(len(usable))
    covariance[..., each, each] += noise**2
    scale = np.sqrt(covariance[..., each, each])
    scale = np.where(here & (scale > 0), scale, 1.0)
    correlation = covariance / scale[..., :, None] / scale[..., None, :]
    correlation[..., each, each] = 1.0 + ALIKE
    raw = np.linalg.solve(correlation, (here / scale)[..., None])[..., 0] / scale
    raw = np.where(here, np.maximum(raw, 0.0), 0.0)
    total = raw.sum(axis=-1, keepdims=True)
    return np.moveaxis(np.divide(raw, total, out=np.zeros_like(raw), where=total > 0), -1, 0)

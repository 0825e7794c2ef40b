"""Coverage intervals of draws (JCGM 101, 7.7) and coverage regions (JCGM 102, 7.7)."""

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.uncertainty._coverage import PROBABILITY, check_probability

Array = NDArray[np.float64]

DEPENDENT = 1e-12  # an eigenvalue of a correlation matrix: less is rounding


def symmetric_interval(values: Array, probability: float = PROBABILITY) -> Array:
    """Probabilistically symmetric interval (2, ...) of draws `values` (m, ...) along the first axis."""
    check_probability(probability)
    return np.quantile(values, [(1 - probability) / 2, (1 + probability) / 2], axis=0, method="hazen")


def shortest_interval(values: Array, probability: float = PROBABILITY) -> Array:
    """The shortest interval (2, ...) that holds `probability` of the draws (m, ...): for skew distributions."""
    check_probability(probability)
    ordered = np.sort(values, axis=0)
    inside = round(probability * len(ordered))
    if not 0 < inside < len(ordered):
        raise InputError(f"{len(ordered)} draws are too few for an interval of {100 * probability:g} %; draw more.")
    start = (ordered[inside:] - ordered[:-inside]).argmin(axis=0)[None]
    return np.concatenate([np.take_along_axis(ordered, start + step, axis=0) for step in (0, inside)])


def ellipsoid_factor(values: Array, mean: Array, covariance: Array, *, probability: float = PROBABILITY) -> float:
    """Factor k: (y - mean)' covariance^-1 (y - mean) <= k^2 holds `probability` of the draws (m, q).

    Outputs that depend on each other linearly are taken together.
    """
    u = np.sqrt(np.diag(covariance))
    scale = np.where(u > 0, u, 1.0)
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = eigenvalues > DEPENDENT
    whitened = ((values - mean) / scale) @ (vectors[:, kept] / np.sqrt(eigenvalues[kept]))
    return float(np.sqrt(np.quantile(np.einsum("mq,mq->m", whitened, whitened), probability)))


def rectangle_factor(values: Array, mean: Array, u: Array, *, probability: float = PROBABILITY) -> float:
    """Factor k: |y_j - mean_j| <= k u_j for all outputs j holds `probability` of the draws (m, q)."""
    scale = np.where(u > 0, u, 1.0)
    return float(np.quantile(np.abs((values - mean) / scale).max(axis=1), probability))

"""Effective degrees of freedom and coverage factors (JCGM 100, annex G)."""

from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

PROBABILITY = 0.95


def effective_degrees_of_freedom(contributions: ArrayLike, degrees_of_freedom: ArrayLike) -> Array:
    """Welch-Satterthwaite (JCGM 100, eq. G.2b) of `contributions` (..., k) = |c| u with `degrees_of_freedom` (k,).

    It holds for independent contributions only. Correlated inputs, say of one calibration, enter as one contribution
    sqrt(c' V c) with the degrees of freedom of that calibration; `Budget` does so. Not truncated to an integer.
    """
    squares, nu = np.square(np.asarray(contributions, dtype=float)), np.asarray(degrees_of_freedom, dtype=float)
    if not (nu > 0).all():
        raise InputError(f"Degrees of freedom must be above 0, got {np.min(nu)}; give inf where u is well known.")
    total = squares.sum(axis=-1)
    scale = np.where(total > 0, total, 1.0)
    fourth = ((squares / scale[..., None]) ** 2 / nu).sum(axis=-1)
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(np.isnan(total), np.nan, 1 / fourth))


def coverage_factor(probability: float = PROBABILITY, degrees_of_freedom: ArrayLike = inf) -> Array:
    """Student's t of a two-sided interval with `probability` (JCGM 100, G.3.2); infinite degrees are normal.

    An array like `degrees_of_freedom`; a 0-dimensional one counts as a number.
    """
    check_probability(probability)
    nu = np.asarray(degrees_of_freedom, dtype=float)
    if (nu <= 0).any():
        raise InputError(f"Degrees of freedom must be above 0, got {np.min(nu)}; give inf where u is well known.")
    from scipy.special import ndtri, stdtrit

    upper = (1 + probability) / 2
    return np.asarray(np.where(np.isinf(nu), ndtri(upper), stdtrit(np.where(np.isinf(nu), 1.0, nu), upper)))


def check_probability(probability: float) -> None:
    if not 0 < probability < 1:
        raise InputError(
            f"A coverage probability lies between 0 and 1, got {probability}; give a fraction, 0.95 for 95 %."
        )

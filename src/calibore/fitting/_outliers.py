"""Residuals that belong to something else: found by a resistant fit, then left out altogether.

Tukey's biweight (Holland and Welsch 1977) finds them. What agrees within 4 robust standard deviations is then fitted by
least squares: of normal noise that leaves out 1 in 16 000, and the covariance is that of ordinary least squares.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._minimise import minimise
from calibore.fitting._problem import Mask, Problem, Rows

Array = NDArray[np.float64]

AGREEING = 4.0  # robust standard deviations
TUKEY_TUNING = 4.685  # standard deviations; 95 % efficiency on normal noise
MEDIAN_TO_DEVIATION = 1.4826  # median of |x| to standard deviation of normal x
FAINTEST = 1e-18  # smallest noise, in the unit of the data
ROUNDING = 1e-12  # of the largest residual: a deviation that is none
FIRST_STEPS = 5  # with weights 1 / |residual|, which no start can mislead as a redescending weight can
STEPS = 30
SETTLED = 1e-3  # change of a weight


def resistant(problem: Problem, start: Array, usable: Mask) -> tuple[Array, Mask]:
    """Parameters that outliers do not pull, and which residuals agree with them."""
    rows, values = problem.rows(usable), start
    deviation, weights = first_deviation(problem, rows, values), np.ones(rows.index.size)
    residuals = weights
    for number in range(STEPS):
        values = minimise(_weighted(problem, rows, weights / deviation**2), values, rough=True)
        residuals = problem.linearised(values, rows)[0]
        residuals = residuals - rows.loads @ _group_errors(rows, residuals, weights)
        deviation = _deviation(residuals)
        before, relative = weights, residuals / deviation
        weights = 1 / np.maximum(np.abs(relative), 1) if number < FIRST_STEPS else _tukey(relative)
        if number > FIRST_STEPS and np.abs(weights - before).max() < SETTLED:
            break
    return values, agreeing(usable, rows, residuals)


def first_deviation(problem: Problem, rows: Rows, values: Array) -> float:
    """A standard deviation of residuals of sigma 1 to begin with; it matters beside a prior only."""
    return _deviation(problem.linearised(values, rows)[0]) if problem.aims.size else 1.0


def agreeing(usable: Mask, rows: Rows, residuals: Array) -> Mask:
    """Which of the `usable` agree with the fit; `residuals` (m,) of sigma 1 without their groups' errors."""
    result = np.zeros(usable.size, dtype=bool)
    result[rows.index] = np.abs(residuals) <= AGREEING * _deviation(residuals)
    return result


def _weighted(problem: Problem, rows: Rows, weights: Array):
    root = np.sqrt(weights)

    def function(values: Array) -> tuple[Array, Array]:
        residuals, jacobian = problem.linearised(values, rows)
        aside = problem.aims - problem.known @ values
        return np.concatenate([root * residuals, aside]), np.concatenate([root[:, None] * jacobian, problem.known])

    return function


def _group_errors(rows: Rows, residuals: Array, weights: Array) -> Array:
    above, below = rows.loads.T @ (weights * residuals), rows.loads.power(2).T @ weights
    return above / np.where(below > 0, below, 1.0)


def _deviation(residuals: Array) -> float:
    floor = ROUNDING * float(np.abs(residuals).max(initial=0))
    return max(MEDIAN_TO_DEVIATION * float(np.median(np.abs(residuals))), floor, FAINTEST)


def _tukey(relative: Array) -> Array:
    return np.maximum(1 - (relative / TUKEY_TUNING) ** 2, 0.0) ** 2

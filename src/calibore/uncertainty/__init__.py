"""Standard uncertainties and their propagation (JCGM 100, 101, 102); knows nothing of pipes.

`Quantity`      a number with its standard uncertainty
`Covariance`    of named inputs, with distributions and degrees of freedom; `factor()` works for singular ones, `draw()`
`Distribution`  normal, rectangular, triangular, arcsine; u of limits
`Scores`        how correlated inputs are drawn, for engines that draw themselves
`propagate`     sensitivities x covariance -> modes and standard uncertainty
`budget`, `budget_of_mean`  -> `Budget`: which input contributes how much, common or independent
`effective_degrees_of_freedom`, `coverage_factor`  from u to an expanded uncertainty
`monte_carlo`   -> `MonteCarloResult`: draws until u has settled; intervals and regions of draws
`least_variance_weights`   several measurements of one quantity made one
`method_for`    -> `Method`: first order, Monte Carlo or not measurable, by the margin
"""

from calibore.uncertainty._budget import Budget, budget, budget_of_mean
from calibore.uncertainty._covariance import Covariance
from calibore.uncertainty._coverage import coverage_factor, effective_degrees_of_freedom
from calibore.uncertainty._distributions import Distribution
from calibore.uncertainty._intervals import ellipsoid_factor, rectangle_factor, shortest_interval, symmetric_interval
from calibore.uncertainty._method import FIRST_ORDER_FROM, MEASURABLE_ABOVE, Method, method_for
from calibore.uncertainty._monte_carlo import MonteCarloResult, monte_carlo, tolerance_of
from calibore.uncertainty._propagation import Propagation, propagate
from calibore.uncertainty._quantity import Quantity
from calibore.uncertainty._scores import Scores
from calibore.uncertainty._weighting import least_variance_weights

__all__ = [
    "FIRST_ORDER_FROM",
    "MEASURABLE_ABOVE",
    "Budget",
    "Covariance",
    "Distribution",
    "Method",
    "MonteCarloResult",
    "Propagation",
    "Quantity",
    "Scores",
    "budget",
    "budget_of_mean",
    "coverage_factor",
    "effective_degrees_of_freedom",
    "ellipsoid_factor",
    "least_variance_weights",
    "method_for",
    "monte_carlo",
    "propagate",
    "rectangle_factor",
    "shortest_interval",
    "symmetric_interval",
    "tolerance_of",
]

"""Least squares that says what it does not know: fits, their covariance, identifiability, comparison of models.

Knows nothing of cameras. `least_squares` -> `Fit`; `identifiability`, `information_criteria`, `region_contains` of it.
"""

from calibore.fitting._criteria import Criteria, cross_validated, information_criteria
from calibore.fitting._fit import Fit
from calibore.fitting._identifiability import Identifiability, identifiability
from calibore.fitting._least_squares import least_squares
from calibore.fitting._problem import Prior
from calibore.fitting._region import Region, mahalanobis, region, region_contains

__all__ = [
    "Criteria",
    "Fit",
    "Identifiability",
    "Prior",
    "Region",
    "cross_validated",
    "identifiability",
    "information_criteria",
    "least_squares",
    "mahalanobis",
    "region",
    "region_contains",
]

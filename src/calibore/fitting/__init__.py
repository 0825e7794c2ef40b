"""Least squares that says what it does not know: fits, their covariance, identifiability, comparison of models.

Knows nothing of cameras. `least_squares` -> `Fit`.
"""

from calibore.fitting._fit import Fit
from calibore.fitting._least_squares import least_squares
from calibore.fitting._region import Region, mahalanobis, region, region_contains

__all__ = ["Fit", "Region", "least_squares", "mahalanobis", "region", "region_contains"]

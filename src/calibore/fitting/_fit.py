"""What a fit found, and how well."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fit:
    """`values` (p,) of the parameters `names`, SI or px; `covariance` (p, p), scatter, correlated neighbours and errors
    shared by groups included; `degrees_of_freedom` of the scatter it rests on.

    `residuals` (n,) measured minus predicted, in the unit of the data; `jacobian` (n, p) of the predictions; `sigma`
    (n,) standard deviations of the residuals as found; `weights` (n,) 0 where a residual was left out; `noise`:
    standard deviation of one residual about the model, groups' errors apart; `group_sigma`: standard deviation of what the
    residuals of one group share.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    degrees_of_freedom: float
    residuals: Array
    jacobian: Array
    sigma: Array
    weights: Array
    noise: float
    group_sigma: float = 0.0

    @property
    def u(self) -> Array:
        """Standard uncertainties (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def value(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

"""What a designer assumes about how well a rig is known: the dissertation's way, the honest way, or any other."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.uncertainty import Covariance, Distribution

Rule = Literal["best", "minimum-variance"]
LENGTH_LIMIT = 0.001  # of the nominal radius (Swanbom 2007, sections 3.3.2 and 4.3.2)
Direction = Literal["scan"] | NDArray[np.float64] | None
"""Of the noise in the image: along the scan (radial for rings, along u for a side-facing line), along given unit
vectors, or None for u and v alike."""


@dataclass(frozen=True)
class Assumptions:
    """`length`: standard uncertainty of the lengths a rig is built to, as a fraction of the nominal radius, with its
    `distribution`; `correlated`: angles are known through those lengths and move with them; `direction` of the noise
    of `u_pixel` [px]; `coverage_factor` k of the expanded uncertainties U = k u; `rule` by which lasers are combined.
    """

    length: float
    distribution: Distribution = Distribution.NORMAL
    correlated: bool = True
    direction: Literal["scan"] | None = "scan"
    u_pixel: float = 1.0
    coverage_factor: float = 2.0
    rule: Rule = "minimum-variance"

    def __post_init__(self) -> None:
        if not 0 <= self.length < np.inf:
            raise InputError(
                f"The standard uncertainty of lengths must be 0 or more, got {self.length} of the nominal radius; "
                "give its absolute value."
            )
        if not 0 <= self.u_pixel < np.inf:
            raise InputError(
                f"The standard uncertainty of a line position must be 0 or more, got {self.u_pixel} px; "
                "give its absolute value."
            )

    def covariance(self, names: tuple[str, ...], jacobian: NDArray[np.float64], *, nominal_radius: float) -> Covariance:
        """Of the parameters `names` (p,), from their derivatives `jacobian` (p, l) by l lengths of equal uncertainty.

        Uncorrelated: each keeps its own uncertainty (Swanbom 2007, eqs. 3-46, 3-47, 5-36), as if measured apart.
        """
        matrix = (self.length * nominal_radius) ** 2 * (jacobian @ jacobian.T)
        if not self.correlated:
            matrix = np.diag(np.diag(matrix))
        return Covariance(names, matrix, [self.distribution] * len(names))


AS_PUBLISHED = Assumptions(LENGTH_LIMIT, correlated=False, direction=None, coverage_factor=1.0, rule="best")
"""Swanbom 2007: limits propagated as they are, derived angles as independent inputs, noise in both axes."""

HONEST = Assumptions(Distribution.RECTANGULAR.u_of_limits(LENGTH_LIMIT), Distribution.RECTANGULAR)
"""The same limits as a rectangular distribution, angles that move with their lengths, noise along the scan only."""

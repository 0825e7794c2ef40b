"""What a fit found, and how well."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._likelihood import Unknowns
from calibore.fitting._mixed import MixedModel

Array = NDArray[np.float64]


class Ties(NamedTuple):
    """What ties the residuals of a fit together: `group` (n,), `load` (n,) of the group's error on each, `chain` (n,),
    -1 of none; `prior` (k, p + 1) rows of unit variance, L (parameters - values) = the last column; what was known of
    the scatter. With them the fit can be made again.
    """

    group: NDArray[np.intp]
    load: Array
    chain: NDArray[np.intp]
    prior: Array
    known_noise: bool
    known_group_sigma: float | None


@dataclass(frozen=True, eq=False)
class Fit:
    """`values` (p,) of the parameters `names`, SI or px; `covariance` (p, p), scatter, correlated neighbours and errors
    shared by groups included, infinite for what is not identifiable; `degrees_of_freedom` of the scatter it rests on,
    those of the least known parameter.

    `residuals` (n,) measured minus predicted, in the unit of the data; `jacobian` (n, p) of the predictions; `sigma`
    (n,) standard deviations of the residuals as found; `weights` (n,) 0 where a residual was left out; `noise`:
    standard deviation of one residual of sigma 1 about the model, groups' errors apart; `group_sigma`: standard
    deviation of what the residuals of one group share; `partial_autocorrelation` (q,) of neighbours, empty where none.

    `covariance_modes` (k, p, p): how the covariance itself may be wrong, one standard deviation each, independent;
    none where the scatter is known. `information_root` (p, p): R of the whitened Jacobian's QR, prior included. `ties`:
    what else the fit was given. `evidence`: the linearised model and what its likelihood lacks.
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
    partial_autocorrelation: Array = field(default_factory=lambda: np.zeros(0))
    covariance_modes: Array | None = None
    information_root: Array | None = None
    ties: Ties | None = None
    evidence: tuple[MixedModel, Unknowns, float] | None = field(default=None, repr=False)

    @property
    def u(self) -> Array:
        """Standard uncertainties (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def value(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    def degrees_of_freedom_of(self, combination: Sequence[float] | Array) -> float:
        """Satterthwaite's degrees of freedom of the variance of `combination` (p,) @ values; inf of a known one."""
        c = np.asarray(combination, dtype=float)
        return satterthwaite(c, self.covariance, self.covariance_modes)


def satterthwaite(combination: Array, covariance: Array, modes: Array | None) -> float:
    """2 v^2 / var(v) of v = c' covariance c (Giesbrecht and Burns 1985)."""
    used = combination != 0
    c = combination[used]
    if modes is None or not np.isfinite(covariance[np.ix_(used, used)]).all():
        return np.inf
    doubt = float(np.sum((modes[:, used][:, :, used] @ c @ c) ** 2))
    return 2 * float(c @ covariance[np.ix_(used, used)] @ c) ** 2 / doubt if doubt > 0 else np.inf

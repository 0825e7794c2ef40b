"""Standard uncertainties and their propagation; knows nothing of pipes.

`Quantity`    a number with its standard uncertainty
`Covariance`  of named parameters; `factor()` works for singular ones
`propagate`   sensitivities x covariance -> modes and standard uncertainty
"""

from calibore.uncertainty._covariance import Covariance, Propagation, propagate
from calibore.uncertainty._quantity import Quantity

__all__ = ["Covariance", "Propagation", "Quantity", "propagate"]

"""[drift] of a rig file: what is known of its parameters, widened by how far they may have moved since."""

import numpy as np

from calibore.rigs._stated import Inputs, Stated
from calibore.uncertainty import Covariance, Distribution, effective_degrees_of_freedom

SHAPES_A_SUM = 0.75
"""Share of the variance from which on a part's distribution is that of the sum; below, the sum is nearly normal."""


def widened(known: Covariance | None, drift: Inputs) -> Covariance | None:
    """`known` with the variances of `drift` added, uncorrelated; what only `drift` names joins it. Degrees of freedom
    of a sum by Welch and Satterthwaite, 0 is no drift.
    """
    moving = {name: stated for name, stated in drift.items() if stated.u > 0}
    if not moving:
        return known
    if known is None:
        return _alone(moving)
    matrix, stated = known.matrix.copy(), []
    for at, name in enumerate(known.names):
        u = float(known.u[at])
        own = Stated(u, known.distributions[at], known.degrees_of_freedom[at])
        stated.append(_sum(own, moving[name]) if name in moving else own)
        matrix[at, at] += stated[-1].u ** 2 - u**2 if name in moving else 0.0
    shapes, freedom = [one.distribution for one in stated], [one.degrees_of_freedom for one in stated]
    together = Covariance(known.names, matrix, shapes, freedom)
    new = {name: one for name, one in moving.items() if name not in known.names}
    return together.joined(_alone(new)) if new else together


def _alone(inputs: Inputs) -> Covariance:
    return Covariance.independent(
        {name: one.u for name, one in inputs.items()},
        distributions={name: one.distribution for name, one in inputs.items()},
        degrees_of_freedom={name: one.degrees_of_freedom for name, one in inputs.items()},
    )


def _sum(first: Stated, second: Stated) -> Stated:
    u = float(np.hypot(first.u, second.u))
    freedom = effective_degrees_of_freedom([first.u, second.u], [first.degrees_of_freedom, second.degrees_of_freedom])
    larger = max(first, second, key=lambda one: one.u)
    shape = larger.distribution if larger.u**2 >= SHAPES_A_SUM * u**2 else Distribution.NORMAL
    return Stated(u, shape, float(freedom))

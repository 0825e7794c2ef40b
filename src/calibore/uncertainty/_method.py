"""How far first order carries: by the margin to the place where a measurement ceases to exist."""

from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

FIRST_ORDER_FROM = 4.0  # standard uncertainties: second order is 1 / (4 m), so 6 % of u and less
MEASURABLE_ABOVE = 1.0  # below, one draw in six and more has no result


class Method(IntEnum):
    """How the uncertainty of a point is to be found."""

    FIRST_ORDER = 0
    MONTE_CARLO = 1
    NOT_MEASURABLE = 2


def method_for(margin: ArrayLike) -> NDArray[np.uint8]:
    """The `Method` of each `margin`: first order from 4, Monte Carlo above 1, else (NaN too) not measurable."""
    m = np.asarray(margin, dtype=float)
    methods = np.where(m > MEASURABLE_ABOVE, Method.MONTE_CARLO, Method.NOT_MEASURABLE)
    return np.where(m >= FIRST_ORDER_FROM, Method.FIRST_ORDER, methods).astype(np.uint8)

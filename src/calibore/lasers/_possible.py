"""Numbers that a surface of light may have: products of two or three of them are still numbers."""

import numpy as np
from numpy.typing import ArrayLike

MOST = 1e6
"""m, rad or slope; beyond any pipe."""


def possible(numbers: ArrayLike) -> bool:
    """Whether all of `numbers` are finite and no larger than `MOST`."""
    return bool((np.abs(numbers) <= MOST).all())

"""Weights that leave out what does not belong: Tukey's biweight about a scale from the median."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TUNING = 4.685
"""Standard deviations; 95 % efficient where all is normal (Holland and Welsch 1977)."""
TO_DEVIATION = 1.4826
"""Median of |x| to standard deviation of normal x."""
NU = 3.0
"""Degrees of freedom of the distribution of residuals: features that differ are no proof against a motion."""
LEAST = 1e-3
"""Scale of residuals over their standard uncertainty below which they are exact."""


def tukey(relative: Array) -> Array:
    """(n,) weights, 0 ... 1, of residuals in standard deviations."""
    return np.maximum(1 - (relative / TUNING) ** 2, 0.0) ** 2


def scale_of(relative: Array) -> float:
    """Robust standard deviation of residuals (n,) in units of their standard uncertainty."""
    return max(TO_DEVIATION * float(np.median(np.abs(relative))), LEAST)


def cost_of(left: Array, sigma: Array, scale: float) -> float:
    """Mean negative log likelihood of residuals `left` (n,) under Student's distribution."""
    relative = left / (scale * sigma)
    return float(np.mean((NU + 1) / 2 * np.log1p(relative**2 / NU) + np.log(sigma)) + np.log(scale))

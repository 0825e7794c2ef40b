"""The centre of a ring: that of the circle, freed of ovality, on which its points lie without the features.

Points off a circle with a second harmonic lose their weight (Tukey), so that neither a dent nor an opening pulls the
centre, and with an arc missing the circle does not follow the ovality into the gap.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import clock_of
from calibore.metrics._harmonics import harmonic_basis

Array = NDArray[np.float64]

HARMONICS = 2
TUKEY = 4.685  # 95 % efficient on normal noise, no weight beyond
ROUNDS, TUKEY_ROUNDS = 12, 8
SETTLED = 1e-7  # of the radius
RIDGE = 1e-9  # keeps a few points on a short arc solvable


def robust_centre(points: Array, sigma: Array, *, start: Array) -> Array:
    """Centre (2,) of the ring through `points` (n, 2) with standard uncertainties `sigma` (n,), mean radius about 1,
    from a `start` that features have not misled.

    Raises InputError where the points go round a centre that leaves the origin, the rig axis, outside.
    """
    centre = _descend(points, sigma, start)
    if not np.hypot(*centre) < 1:
        raise InputError("The rig axis lies outside the circle through the points; there is no ring round it.")
    return centre


def spread(values: Array) -> float:
    """Standard deviation by the median absolute value."""
    size = np.abs(values)
    return 1.4826 * float(np.partition(size, size.size // 2)[size.size // 2])


def _descend(points: Array, sigma: Array, start: Array) -> Array:
    """The centre (2,) reached from `start`: fit, move to the fitted centre, again."""
    centre, coefficients = start, np.zeros(2 * HARMONICS + 1)
    for _ in range(ROUNDS):
        x, y = (points - centre).T
        radius = np.hypot(x, y)
        if coefficients[0] == 0:
            coefficients[0] = np.median(radius)
        coefficients = _tukey_fit(harmonic_basis(clock_of(x, y), HARMONICS), radius, coefficients, sigma=sigma)
        shift = np.array([coefficients[2], -coefficients[1]])
        centre, coefficients[1:3] = centre + shift, 0.0
        if np.abs(shift).max() < SETTLED:
            break
    return centre


def _tukey_fit(basis: Array, radius: Array, start: Array, *, sigma: Array) -> Array:
    """Coefficients (p,) of `basis` (n, p) for `radius` (n,) with Tukey's weights, from `start`."""
    coefficients = start
    ridge = RIDGE * radius.size * np.eye(start.size)
    for _ in range(TUKEY_ROUNDS):
        off = radius - basis @ coefficients
        weights = np.clip(1 - (off / (TUKEY * (spread(off) + sigma))) ** 2, 0.0, None) ** 2
        weighted = basis.T * weights
        step = np.linalg.solve(weighted @ basis + ridge, weighted @ off)
        coefficients = coefficients + step
        if np.abs(step).max() < SETTLED:
            break
    return coefficients

"""Slopes and bends of a measured wall: of each how much is noise."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from calibore.scans import Profile

Array = NDArray[np.float64]

AGREEING = 5.0
"""Standard deviations within which a difference agrees with a slope."""
BENT = 0.5
"""Of a rise: by so much, twice, the point between may be aside of a pair that has an edge between them."""
NOISY = 2.0
"""Standard deviations of noise up to which a bend is none."""


def clock_bends(profile: Profile) -> Array:
    """(n, m) [m] size of the second difference round the clock, what noise makes of it taken away."""
    return bend(profile.radius, profile.u_independent, axis=1)


def slopes(pairs: Iterable[tuple[Array, Array | float, Array, Array]]) -> Array:
    """(2, n, m) the slope through pairs of differences of radius, over which distances, with which variance, and how
    far their mean is from the point between, twice; nearest pair first; and the slope's variance. As many pairs count
    as one straight line suits: beside an edge only the nearest. Where that is not known, beside a gap, the next must
    have the point between them on their line: else an edge lies in the gap, and there is no slope, 0.
    """
    total, squares, noise, slope = np.zeros(()), np.zeros(()), np.zeros(()), np.zeros((2, 1, 1))
    seen: list[tuple[Array, Array | float, Array]] = []
    for number, (rise, apart, variance, aside) in enumerate(pairs):
        known = np.isfinite(rise) & np.isfinite(apart)
        if number:
            edge = np.abs(aside) > np.maximum(BENT * np.abs(rise), AGREEING * np.sqrt(3 * variance))
            known &= (squares > 0) | ~edge
            rise = np.where(known, rise, np.nan)
        total = total + np.where(known, apart * rise, 0.0)
        squares = squares + np.where(known, np.square(apart), 0.0)
        noise = noise + np.where(known, np.square(apart) * variance, 0.0)
        safe = np.where(squares > 0, squares, 1.0)
        wider = np.stack([total / safe, noise / safe**2])
        seen.append((rise, apart, variance))
        straight = np.all([_suits(wider[0], *one) for one in seen], axis=0)
        slope = np.where(straight | (len(seen) == 1), wider, slope)
    return slope


def _suits(slope: Array, rise: Array, apart: Array | float, variance: Array) -> NDArray[np.bool_]:
    """Whether a difference agrees with a slope within its noise, or is not known."""
    return ~(np.abs(rise - apart * slope) > AGREEING * np.sqrt(variance))


def bend(radius: Array, u: Array, *, axis: int) -> Array:
    """Size (n, m) [m] of the second difference along an axis, round it, as far as it is more than noise; beside a gap
    the difference to the other side, for the wall may bend there.
    """
    before, after = np.roll(radius, 1, axis=axis), np.roll(radius, -1, axis=axis)
    before, after = np.where(np.isnan(before), radius, before), np.where(np.isnan(after), radius, after)
    square = (before - 2 * radius + after) ** 2 - 6 * (NOISY * np.nan_to_num(u)) ** 2
    return np.sqrt(np.maximum(np.nan_to_num(square), 0.0))

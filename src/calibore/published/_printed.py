"""Equations of chapter 3 in the author's own form, to be compared with what this code finds. Angles in radians."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Conjugates(NamedTuple):
    """Both solutions of (3-34) in nominal radii, negative ones included; NaN where they are complex."""

    first: Array
    second: Array
    denominator: Array
    discriminant: Array


def conjugate_solutions(theta: Array, phi: Array, *, baseline: float, aim: float, half_angle: float) -> Conjugates:
    """Swanbom 2007, eqs. 3-31 to 3-34, with the bracket missing in (3-32) put back, and B* and the denominator negated,
    as (3-37) and (3-41) to (3-45) silently presuppose.
    """
    alpha, psi, D = aim, half_angle, baseline
    sin_t, cos_t, sin_p, cos_p = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    along = np.cos(alpha) * cos_t - np.sin(alpha) * sin_p * sin_t
    denominator = np.cos(psi) ** 2 - along**2
    discriminant = np.sin(psi) ** 2 * (cos_p**2 + sin_p**2 * cos_t**2) - (np.cos(alpha) * cos_p * sin_t) ** 2
    b_star = sin_p * sin_t * (np.cos(alpha) ** 2 - np.sin(psi) ** 2) + cos_t * np.sin(2 * alpha) / 2
    root = np.cos(psi) * np.sqrt(np.where(discriminant >= 0, discriminant, np.nan))
    with np.errstate(divide="ignore"):
        first, second = (D * sin_t * (b_star + sign * root) / denominator for sign in (1, -1))
    return Conjugates(first, second, denominator, discriminant)


def zenith_of_zero_discriminant(phi: ArrayLike, *, aim: float, half_angle: float) -> Array:
    """Swanbom 2007, eq. 3-35, printed with the label of the denominator: tan(theta) |cos(phi)| is a constant."""
    tangent = np.sin(half_angle) / np.sqrt(np.cos(aim) ** 2 - np.sin(half_angle) ** 2)
    return np.arctan2(tangent, np.abs(np.cos(phi)))


def zenith_of_zero_denominator(phi: ArrayLike, *, aim: float, half_angle: float) -> Array:
    """Swanbom 2007, eq. 3-36, printed with the label of the discriminant."""
    phi = np.asarray(phi, dtype=float)
    root = np.sqrt(np.sin(half_angle) ** 2 - (np.cos(phi) * np.sin(aim)) ** 2)
    below = np.cos(half_angle) * root + np.sin(phi) * np.sin(2 * aim) / 2
    return np.arctan2(np.cos(aim) ** 2 - np.cos(half_angle) ** 2, below)


def principal_half_angle(baseline: float, projection: ArrayLike) -> Array:
    """Swanbom 2007, eq. 3-11, with the principal arctangent: pi/2 too small where L^2 + D^2 < 1."""
    L = np.asarray(projection, dtype=float)
    return np.arctan(2 * L / (L**2 + baseline**2 - 1)) / 2


def principal_aim(baseline: float, projection: ArrayLike) -> Array:
    """Swanbom 2007, eq. 3-14, with the principal arctangent."""
    return principal_half_angle(baseline, projection) - np.arctan((1 - baseline) / np.asarray(projection, dtype=float))

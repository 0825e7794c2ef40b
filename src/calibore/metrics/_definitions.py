"""The definitions, on plain diameters: name a number by its formula first and by the standard second.

`diameters` (..., d) [m] are D(phi) = r(phi) + r(phi + pi) about one stated centre, in d equally spaced directions over
half a turn; NaN is a direction that was not measured. Nothing here corrects for noise: extreme values of noisy
diameters read too high (`ring_quantities` removes that).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def diameter_mean(diameters: ArrayLike) -> Array:
    """Mean of D(phi) over the directions [m]."""
    return np.nanmean(np.asarray(diameters, dtype=float), axis=-1)


def ovality_f1216_max(diameters: ArrayLike) -> Array:
    """100 (Dmax - Dmean) / Dmean [%]: ASTM F1216 ovality, the form with the largest diameter."""
    return 100 * (np.nanmax(diameters, axis=-1) / diameter_mean(diameters) - 1)


def ovality_f1216_min(diameters: ArrayLike) -> Array:
    """100 (Dmean - Dmin) / Dmean [%]: ASTM F1216 ovality, the form with the smallest diameter."""
    return 100 * (1 - np.nanmin(diameters, axis=-1) / diameter_mean(diameters))


def ovality_range(diameters: ArrayLike) -> Array:
    """100 (Dmax - Dmin) / Dmean [%]: the pipeline form (API 5L out-of-roundness over the mean diameter).

    DNV divides by the nominal diameter; API RP 1111 divides by Dmax + Dmin, which gives half of this.
    """
    return ovality_f1216_max(diameters) + ovality_f1216_min(diameters)


def ovality_harmonic(diameters: ArrayLike) -> Array:
    """100 * 2 |c2| / c0 [%], c_k the Fourier coefficients of r(phi) and so of D(phi) / 2; every direction is needed.

    An ellipse-like wall r = c0 (1 + a cos 2 phi) gives 100 a, as the F1216 forms do; local dents hardly show. Defined
    by its formula; no standard prescribes it.
    """
    diameters = np.asarray(diameters, dtype=float)
    turn = np.exp(2j * np.pi * np.arange(diameters.shape[-1]) / diameters.shape[-1])
    return 200 * np.abs(diameters @ turn) / diameters.sum(axis=-1)


def deflection(diameter: ArrayLike, nominal_diameter: float) -> Array:
    """100 (D0 - D) / D0 [%]: positive where the pipe is smaller than nominal (AASHTO LRFD Construction 30.5.6)."""
    return 100 * (1 - np.asarray(diameter, dtype=float) / nominal_diameter)


def area(radii: ArrayLike) -> Array:
    """Half the integral of r^2 over the turn [m^2]; `radii` (..., n) [m] equally spaced about any inner point."""
    radii = np.asarray(radii, dtype=float)
    return np.pi * np.mean(radii * radii, axis=-1)


def perimeter(radii: ArrayLike) -> Array:
    """Length of the wall [m], jumps included; `radii` (..., n) [m] equally spaced about any inner point.

    Sum over steps of sqrt(dr^2 + r1 r2 dphi^2): exact for a circle, where chords would be short.
    """
    radii = np.asarray(radii, dtype=float)
    following = np.concatenate([radii[..., 1:], radii[..., :1]], axis=-1)
    step = following - radii
    return np.sqrt(step * step + radii * following * (2 * np.pi / radii.shape[-1]) ** 2).sum(axis=-1)


def perimeter_gradient(radii: Array) -> Array:
    """Exact derivatives (n,) of `perimeter` with respect to the radii (n,)."""
    following, square = np.roll(radii, -1), (2 * np.pi / radii.size) ** 2
    step = following - radii
    length = np.sqrt(step * step + radii * following * square)
    return (0.5 * following * square - step) / length + np.roll((0.5 * radii * square + step) / length, 1)


def diameter_equivalent_area(wall_area: ArrayLike) -> Array:
    """2 sqrt(A / pi) [m]: the circle of the same area."""
    return 2 * np.sqrt(np.asarray(wall_area, dtype=float) / np.pi)

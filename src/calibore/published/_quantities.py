"""Which function computes which published quantity, by the names in values.toml; the small arithmetic among them."""

from collections.abc import Callable

import numpy as np

from calibore.published import _cone_numbers as cone
from calibore.published import _plane_numbers as plane
from calibore.published import _side_numbers as side


def speckle_noise(wavelength: float, f_number: float, *, pitch: float) -> float:
    """Noise of a line position [px] at pixels of `pitch` [m] (Swanbom 2007, eqs. 2-19, 3-54)."""
    return wavelength * f_number / (pitch * np.sqrt(2 * np.pi))


def quotient(numerator: float, denominator: float) -> float:
    return numerator / denominator


def share(share: float, whole: float) -> float:
    return share * whole


def total(first: float, second: float) -> float:
    return first + second


def excess(first: float, second: float) -> float:
    """Of the second over the first, as a fraction of the first."""
    return second / first - 1


def percent_change(before: float, after: float) -> float:
    return 100 * excess(before, after)


def percent_of(first: float, second: float, *, whole: float) -> float:
    """Second minus first in per cent of `whole`."""
    return 100 * (second - first) / whole


def percent_of_mean(first: float, second: float) -> float:
    """Second minus first in per cent of their mean: what the column "% of error" of Table 8.3 holds."""
    return percent_of(first, second, whole=(first + second) / 2)


def arc(degrees: float, radius: float) -> float:
    return np.radians(degrees) * radius


def tangent(degrees: float) -> float:
    return np.tan(np.radians(degrees))


def secant(degrees: float) -> float:
    return 1 / np.cos(np.radians(degrees))


QUANTITIES: dict[str, Callable[..., float]] = {
    function.__name__: function
    for function in (
        speckle_noise,
        quotient,
        share,
        total,
        excess,
        percent_change,
        percent_of,
        percent_of_mean,
        arc,
        tangent,
        secant,
        cone.dual_cone_uncertainty,
        cone.crown_deflection,
        cone.dual_worst_azimuth,
        cone.dual_worst_uncertainty,
        cone.touching_azimuth,
        cone.parallel_azimuth,
        plane.plane_field_of_view,
        plane.plane_uncertainty,
        plane.plane_uncertainty_at_centre,
        plane.plane_uncertainty_at_corner,
        plane.plane_bar_tick,
        plane.occlusion_angle,
        side.side_radius,
        side.side_axial,
        side.side_u_radius,
        side.side_u_axial,
        side.side_uncertainty,
        side.side_smallest_radius,
        side.side_aim,
        side.side_zoom,
    )
}

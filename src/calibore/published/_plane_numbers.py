"""Numbers of chapter 4: the perpendicular plane. Lengths in nominal radii."""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from calibore.design import AS_PUBLISHED, Prediction, plane_rig, predict, predict_on_wall
from calibore.rigs import Rig

NOISE = {"u_pixel": AS_PUBLISHED.u_pixel, "direction": AS_PUBLISHED.direction}
BESIDE_CENTRE = 1e-4
"""Pixels: on the axis itself a radius has no slope; so near to it the slope is that of the limit to 1e-13."""

LABELS = 5
"""Steps of a colour bar of Table 4.2."""


@cache
def plane(baseline: float) -> Rig:
    return plane_rig(baseline, inputs=AS_PUBLISHED)


def at_pixel(baseline: float, p: ArrayLike, q: ArrayLike) -> Prediction:
    """At `p`, `q` [px] right and below the image centre, as published."""
    rig = plane(baseline)
    centre_u, centre_v = rig.camera.principal_point
    return predict(rig, centre_u + np.asarray(p, dtype=float), centre_v + np.asarray(q, dtype=float), **NOISE)


def plane_at_radius(baseline: float, radius: ArrayLike, *, rig: Rig | None = None) -> Prediction:
    """On round walls of `radius`, at 3 h."""
    return predict_on_wall(rig or plane(baseline), np.pi / 2, radius, **NOISE)


def plane_field_of_view(baseline: float) -> float:
    """Degrees across the short image axis: twice the zenith of the ray through the middle of its edge (eq. 4-16)."""
    camera = plane(baseline).camera
    ray = camera.unproject([camera.principal_point[0]], [0.0]).direction[0]
    return float(2 * np.degrees(np.arctan2(np.hypot(ray[0], ray[1]), ray[2])))


def plane_uncertainty(baseline: float, *, radius: float = 1.0, nominal_radius: float = 1.0) -> float:
    """U[R] in the unit of `nominal_radius`."""
    return nominal_radius * float(plane_at_radius(baseline, radius).u_radius)


def plane_uncertainty_at_centre(baseline: float) -> float:
    return float(at_pixel(baseline, BESIDE_CENTRE, 0.0).u_radius)


def plane_uncertainty_at_corner(baseline: float) -> float:
    camera = plane(baseline).camera
    return float(at_pixel(baseline, camera.width / 2, camera.height / 2).u_radius)


def plane_bar_tick(baseline: float, *, tick: int, end: float | None = None) -> float:
    """Label `tick` of the colour bar, from the image centre to `end`, by default the image corner."""
    first = plane_uncertainty_at_centre(baseline)
    last = plane_uncertainty_at_corner(baseline) if end is None else end
    return first + tick * (last - first) / LABELS


def occlusion_angle(baseline: float) -> float:
    """Degrees between the wall and the camera ray at R = 1 (eq. 4-25)."""
    point = plane_at_radius(baseline, 1.0)
    return float(np.degrees(np.arctan2(point.radius, point.axial)))

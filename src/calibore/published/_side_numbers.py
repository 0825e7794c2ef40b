"""Numbers of chapter 5: the side-facing head. Lengths in nominal radii."""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from calibore.design import AS_PUBLISHED, Prediction, predict, predict_on_wall, side_rig
from calibore.rigs import Rig, SideFacing

NOISE = {"u_pixel": AS_PUBLISHED.u_pixel, "direction": AS_PUBLISHED.direction}


@cache
def head(baseline: float, *, correlated: bool = False) -> Rig:
    """As published: 1024 px along the range, and the aim as if known apart from the baseline (eq. 5-36)."""
    return side_rig(baseline, inputs=replace(AS_PUBLISHED, correlated=correlated))


def at_pixel(baseline: float, p: ArrayLike, q: ArrayLike) -> Prediction:
    """At `p` [px] from the image centre along the range, `q` [px] along the pipe."""
    rig = head(baseline)
    centre_u, centre_v = rig.camera.principal_point
    return predict(rig, centre_u + np.asarray(p, dtype=float), centre_v - np.asarray(q, dtype=float), **NOISE)


def at_radius(baseline: float, radius: ArrayLike, *, correlated: bool = False) -> Prediction:
    """On the image's centre row."""
    return predict_on_wall(head(baseline, correlated=correlated), 0.0, radius, **NOISE)


def side_radius(baseline: float, *, p: float, q: float) -> float:
    return float(at_pixel(baseline, p, q).radius)


def side_axial(baseline: float, *, p: float, q: float) -> float:
    return float(at_pixel(baseline, p, q).axial)


def side_u_radius(baseline: float, *, p: float, q: float) -> float:
    return float(at_pixel(baseline, p, q).u_radius)


def side_u_axial(baseline: float, *, p: float, q: float) -> float:
    return float(at_pixel(baseline, p, q).u_axial)


def side_uncertainty(baseline: float, *, radius: float = 1.0, nominal_radius: float = 1.0) -> float:
    """U[R] on the centre row, in the unit of `nominal_radius`."""
    return nominal_radius * float(at_radius(baseline, radius).u_radius)


def side_smallest_radius(baseline: float) -> float:
    """Radius in the middle of the image's edge of short range (eq. 5-21)."""
    return side_radius(baseline, p=-head(baseline).camera.width / 2, q=0.0)


def side_aim(baseline: float) -> float:
    """Degrees between the camera axis and the sheet (eq. 5-23)."""
    mount = head(baseline).mount
    assert isinstance(mount, SideFacing)
    return float(np.degrees(mount.aim))


def side_field_of_view(baseline: float) -> float:
    """Degrees along the range (eq. 5-22)."""
    camera = head(baseline).camera
    return float(np.degrees(camera.lens.zenith(camera.width / 2) * 2))


def side_zoom(baseline: float) -> float:
    """Degrees per pixel along the range."""
    return side_field_of_view(baseline) / head(baseline).camera.width

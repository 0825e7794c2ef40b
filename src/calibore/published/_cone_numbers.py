"""Numbers of chapter 3: one and two cones. Lengths in nominal radii, azimuths in degrees from the right."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.design import AS_PUBLISHED, Prediction, combine_lasers, cone_rig, predict_on_wall
from calibore.lasers import Cone
from calibore.rigs import Rig, lit_points, triangulate

Array = NDArray[np.float64]
LONG_AXIS = 1024
SECOND_CLOCK = -np.pi / 2  # the second laser at azimuth 180 deg: the worst azimuth is then -45 deg, as printed
FAR = 1  # the row of `Cone.meet` where the ray leaves the light
ITS_OWN = 1e-6
EVERY = np.arange(-179.5, 180.0, 0.25)


def clock_of_azimuth(azimuth: ArrayLike) -> Array:
    """Clock [rad] from the crown; the dissertation counts `azimuth` [deg] from the right, upwards."""
    return np.radians(90.0 - np.asarray(azimuth, dtype=float))


@cache
def square_rig(
    baseline: float, projection: float, *, lasers: int = 1, correlated: bool = False, pixels: int = LONG_AXIS
) -> Rig:
    """A cone rig as published; its image is square: section 3.3.5 neglects the aspect ratio."""
    inputs = replace(AS_PUBLISHED, correlated=correlated)
    second = SECOND_CLOCK if lasers == 2 else None
    return cone_rig(baseline, projection, second_clock=second, width=pixels, height=pixels, inputs=inputs)


def on_wall(rig: Rig, azimuth: ArrayLike, radius: ArrayLike = 1.0, *, laser: int = 0) -> Prediction:
    """As published: one pixel of noise along u and along v (eqs. 3-57, 3-59)."""
    noise = {"u_pixel": AS_PUBLISHED.u_pixel, "direction": AS_PUBLISHED.direction}
    return predict_on_wall(rig, clock_of_azimuth(azimuth), radius, laser=laser, **noise)


def u_on_wall(rig: Rig, azimuth: ArrayLike, radius: ArrayLike = 1.0, *, laser: int = 0) -> Array:
    """U[R] there; NaN where the wall's own meeting is too grazing and only the other one is left."""
    found = on_wall(rig, azimuth, radius, laser=laser)
    return np.where(np.abs(found.radius / np.asarray(radius, dtype=float) - 1) < ITS_OWN, found.u_radius, np.nan)


def composite(rig: Rig, azimuth: ArrayLike) -> Array:
    """U[R] of the better of two lasers (section 3.3.5)."""
    return combine_lasers([on_wall(rig, azimuth, laser=number) for number in (0, 1)], rule="best").u_radius


def dual_cone_uncertainty(
    baseline: float,
    projection: float,
    *,
    azimuth: float = -45.0,
    radius: float = 1.0,
    pixels: int = LONG_AXIS,
    correlated: bool = False,
) -> float:
    """U[R] where two lasers are worst; there both are alike, so one is enough (sections 3.3.5, 3.4)."""
    rig = square_rig(baseline, projection, pixels=pixels, correlated=correlated)
    return float(on_wall(rig, azimuth, radius).u_radius)


def dual_worst_azimuth(baseline: float, projection: float) -> float:
    """Azimuth [deg], to 0.25 deg, of the largest composite uncertainty."""
    return float(EVERY[np.nanargmax(composite(square_rig(baseline, projection, lasers=2), EVERY))])


def dual_worst_uncertainty(baseline: float, projection: float) -> float:
    return float(np.nanmax(composite(square_rig(baseline, projection, lasers=2), EVERY)))


def crown_deflection(baseline: float, projection: float = 2.0) -> float:
    """1 - R of the uppermost pixel (eq. 3-37, the second of that number)."""
    rig = square_rig(baseline, projection)
    return float(1 - triangulate(rig, rig.camera.principal_point[0], 0.0, branch=FAR).radius[0])


def touching_azimuth(baseline: float, projection: float) -> float:
    """Azimuth [deg] on R = 1 where the camera ray touches the cone: the near and the far meeting are one."""
    rig = square_rig(baseline, projection)
    return _azimuth_where(rig, lambda cone, points: np.einsum("ni,ni->n", cone.gradient(points), _rays(points)))


def parallel_azimuth(baseline: float, projection: float) -> float:
    """Azimuth [deg] on R = 1 where the camera ray is parallel to the light, and its far meeting at infinity."""
    rig = square_rig(baseline, projection)
    return _azimuth_where(rig, lambda cone, points: _rays(points) @ cone.axis - np.cos(cone.half_angle))


def _azimuth_where(rig: Rig, slope: Callable[[Cone, Array], Array]) -> float:
    from scipy.optimize import brentq

    cone = rig.lasers[0].surface
    assert isinstance(cone, Cone)

    def at(azimuth: float) -> float:
        return float(slope(cone, lit_points(rig, clock_of_azimuth(azimuth), 1.0))[0])

    found = brentq(at, -80.0, 57.0, xtol=1e-12)
    assert isinstance(found, float)
    return found


def _rays(points: Array) -> Array:
    return points / np.linalg.norm(points, axis=1)[:, None]

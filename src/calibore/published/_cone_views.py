"""What a camera beside a cone of light sees, pixel by pixel: meetings, regions, frontiers."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from calibore.design import AS_PUBLISHED, cone_rig
from calibore.lasers import Cone, MeetingFlag
from calibore.optics import Camera, Lens
from calibore.published._pictures import Curve, Region, Tone
from calibore.rigs import Rig, lit_points, meetings_of, triangulate

Array = NDArray[np.float64]
BASELINES = (0.25, 0.50, 0.75)
PROJECTIONS = (0.50, 0.75, 1.00, 2.00, 5.00)
"""Columns and rows of Tables 3.1 to 3.3."""

CELLS = 180
"""Pixels across a map of all rays ahead of the camera."""

STEP = 8
"""Pixels of the sensor per pixel of a map of the limited field of view."""

NEAR, FAR = 0, 1


@dataclass(frozen=True, eq=False)
class View:
    """Pixels `u`, `v` (h, w) of `rig`, with `x`, `y` [deg] of the image, upwards and to the right."""

    rig: Rig
    u: Array
    v: Array
    x: Array
    y: Array

    @property
    def cone(self) -> Cone:
        surface = self.rig.lasers[0].surface
        assert isinstance(surface, Cone)
        return surface

    @property
    def zenith(self) -> Array:
        """(h, w) [rad]."""
        return np.radians(np.hypot(self.x[None, :], self.y[:, None]))

    @property
    def azimuth(self) -> Array:
        """(h, w) [rad], as the dissertation counts it."""
        return np.arctan2(self.y[:, None], self.x[None, :])


@cache
def whole_view(baseline: float, projection: float) -> View:
    """Every ray up to 90 deg from the camera axis, as the polar plots of section 3.2.6 show them."""
    k = CELLS / np.pi
    camera = Camera(CELLS, CELLS, Lens("equidistant", k, CELLS / 2), ((CELLS - 1) / 2, (CELLS - 1) / 2))
    built = cone_rig(baseline, projection, inputs=AS_PUBLISHED)
    rig = Rig(built.configuration, camera, built.lasers, built.covariance)
    return _view(rig, np.arange(float(CELLS)), np.arange(float(CELLS)))


@cache
def limited_view(baseline: float, projection: float) -> View:
    """The 4:3 field of view of section 3.2.7. It is bounded above and below (figure 3.14) and counted along the long
    axis (3-58): the long axis stands upright.
    """
    rig = cone_rig(baseline, projection, width=768, height=1024, inputs=AS_PUBLISHED)
    return _view(rig, *(np.arange(STEP / 2, side, STEP) for side in (768, 1024)))


def _view(rig: Rig, columns: Array, rows: Array) -> View:
    u, v = np.meshgrid(columns, rows)
    (centre_u, centre_v), degrees = rig.camera.principal_point, np.degrees(1 / rig.camera.lens.k)
    return View(rig, u, v, (columns - centre_u) * degrees, (centre_v - rows) * degrees)


def ring_of(view: View, tone: Tone = "black") -> Curve:
    """The line of light on a wall of R = 1, in the image."""
    clock = np.linspace(0.0, 2 * np.pi, 361)
    u, v = view.rig.project(lit_points(view.rig, clock, 1.0))
    (centre_u, centre_v), degrees = view.rig.camera.principal_point, np.degrees(1 / view.rig.camera.lens.k)
    return Curve((u - centre_u) * degrees, (centre_v - v) * degrees, "ring on a wall of R = 1", tone)


def regions(view: View, values: Array | None = None) -> NDArray[np.uint8]:
    """(h, w): complex where the ray misses the cone, negative where it would meet it behind the camera, grazing where
    it meets the cone so flatly that `values` has none.
    """
    rays = view.rig.camera.unproject(view.u.ravel(), view.v.ravel())
    touching = view.cone.frontier(rays.origin, rays.direction).value[0].reshape(view.u.shape)
    region = np.where(touching < 0, Region.COMPLEX, Region.NEGATIVE)
    region = np.where(np.isfinite(both_radii(view)).any(axis=0), Region.MEASURED, region)
    if values is not None:
        region = np.where((region == Region.MEASURED) & np.isnan(values), Region.GRAZING, region)
    return np.where(view.zenith > np.pi / 2, Region.UNSEEN, region).astype(np.uint8)


def both_radii(view: View) -> Array:
    """(2, h, w) near and far, however grazing; NaN where there is none ahead of the camera."""
    return existing_radii(view.rig, view.u.ravel(), view.v.ravel()).reshape(2, *view.u.shape)


def existing_radii(rig: Rig, u: Array, v: Array) -> Array:
    """(2, n) at pixels (n,)."""
    found = meetings_of(rig, u, v)
    ahead = (found.flags != MeetingFlag.NONE) & (found.distance > 0)
    way = rig.camera.unproject(u, v).direction
    return np.where(ahead, found.distance, np.nan) * np.hypot(way[:, 0], way[:, 1])


def printed_branch(view: View) -> NDArray[np.intp]:
    """(h, w) what (3-37) takes: of two meetings the far one, always."""
    return np.where(np.isfinite(both_radii(view)[FAR]), FAR, NEAR)


def printed_radii(view: View) -> Array:
    return np.take_along_axis(both_radii(view), printed_branch(view)[None], axis=0)[0]


def our_radii(view: View, prior_radius: float = 1.0) -> Array:
    """(h, w) of two meetings the one nearer to what the wall roughly is."""
    found = triangulate(view.rig, view.u.ravel(), view.v.ravel(), prior_radius=prior_radius)
    return found.radius.reshape(view.u.shape)

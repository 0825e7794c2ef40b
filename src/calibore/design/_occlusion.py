"""What stands in the way: the angle at which wall and rays meet, and the shadow behind a bump."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.design._ring import ring_clocks
from calibore.errors import InputError
from calibore.lasers import Beam, Cone, LaserSurface, Plane
from calibore.rigs import Rig, lit_points

Array = NDArray[np.float64]
HEIGHTS = np.linspace(0.0, 0.2, 21)  # nominal radii
CLOCKS = 72
NOTHING = 1e-9  # of the nominal radius: rounding


@dataclass(frozen=True, eq=False)
class Occlusion:
    """Of one `laser` at `clock` (c,) [rad] on the nominal wall: angle [rad] between the wall and the ray to the
    `camera`, and to the `light`; 90 deg throws no shadow.
    """

    laser: int
    clock: Array
    camera: Array
    light: Array


@dataclass(frozen=True, eq=False)
class Shadow:
    """Behind a ridge of `height` (h,) [m], the longest over the clocks and lasers [m]: `along` the pipe behind a ridge
    round the wall, `round` the wall beside a ridge along the pipe. NaN where camera or laser stands above the ridge.
    """

    height: Array
    along: Array
    around: Array


def occlusion(rig: Rig, *, nominal_radius: float) -> list[Occlusion]:
    """For a centred perpendicular plane its tangent is R0 / D (Swanbom 2007, eq. 4-25); here for every rig."""
    found = []
    for laser in range(len(rig.lasers)):
        clock, points = _lit(rig, laser, nominal_radius)
        eye, light = _viewpoints(rig, laser)
        found.append(Occlusion(laser, clock, _angle(eye, points), _angle(light, points)))
    return found


def shadows(rig: Rig, *, nominal_radius: float, heights: ArrayLike | None = None) -> Shadow:
    """Exact for straight, thin ridges of the cylinder; where camera and light both are hidden, their union."""
    height = HEIGHTS * nominal_radius if heights is None else np.atleast_1d(np.asarray(heights, dtype=float))
    if not ((height >= 0) & (height < nominal_radius)).all():
        raise InputError(
            f"A bump is lower than the pipe's radius of {nominal_radius:g} m and not negative, got {height.max():g} m."
        )
    each = []
    for laser in range(len(rig.lasers)):
        _, points = _lit(rig, laser, nominal_radius)
        points = points[np.isfinite(points).all(axis=1)]
        views = [_hidden(view, points, nominal_radius, height) for view in _viewpoints(rig, laser)]
        each.append([_union([view[axis] for view in views]).max(axis=1, initial=0.0) for axis in (0, 1)])
    along, around = np.where(np.max(each, axis=0) > NOTHING * nominal_radius, np.max(each, axis=0), 0.0)
    return Shadow(height, along, around)


def _lit(rig: Rig, laser: int, radius: float) -> tuple[Array, Array]:
    clock = ring_clocks(rig, CLOCKS)
    if isinstance(rig.lasers[laser].surface, Beam):
        clock = clock[laser : laser + 1]
    return clock, lit_points(rig, clock, radius, laser=laser)


def _viewpoints(rig: Rig, laser: int) -> tuple[Array, Array]:
    """(3,) [m] of the pupil, and of where the light comes from."""
    return np.asarray(rig.mount.translation, dtype=float), source_of(rig.lasers[laser].surface)


def source_of(surface: LaserSurface) -> Array:
    """(3,) [m]: the apex of a cone, the foot of a beam; the rig axis for planes and sheets, which spread from it."""
    if isinstance(surface, Plane):
        return np.array([0.0, 0.0, surface.baseline])
    if isinstance(surface, Cone):
        return surface.apex
    return surface.source if isinstance(surface, Beam) else np.zeros(3)


def _angle(view: Array, points: Array) -> Array:
    """(n,) between wall and ray: its sine is the ray's part along the wall's normal."""
    rays = points - view
    outwards = points[:, :2] / np.linalg.norm(points[:, :2], axis=1, keepdims=True)
    sine = np.einsum("ni,ni->n", rays[:, :2], outwards) / np.linalg.norm(rays, axis=1)
    return np.arcsin(np.clip(sine, -1, 1))


def _hidden(view: Array, points: Array, radius: float, height: Array) -> tuple[Array, Array]:
    """(h, n) signed shifts, along the pipe and round the wall [m], from each point to where its ray to `view` comes
    out of the layer of `height` on the wall: a ridge in between hides the point.
    """
    rays = view - points
    a = np.einsum("ni,ni->n", rays[:, :2], rays[:, :2])
    b = np.einsum("ni,ni->n", rays[:, :2], points[:, :2])
    level = (radius - height[:, None]) ** 2
    root = np.sqrt(np.maximum(b**2 - a * (radius**2 - level), 0.0))
    leaves = np.where(b**2 >= a * (radius**2 - level), (-b - root) / np.where(a > 0, a, np.nan), np.nan)
    leaves = np.where((leaves <= 1) & (np.hypot(view[0], view[1]) ** 2 < level), leaves, np.nan)
    x, y = (points[:, axis] + leaves * rays[:, axis] for axis in (0, 1))
    turned = np.arctan2(points[:, 0] * y - points[:, 1] * x, points[:, 0] * x + points[:, 1] * y)
    return leaves * rays[:, 2], radius * turned


def _union(shifts: list[Array]) -> Array:
    """Lengths of what is hidden from one viewpoint or another; the intervals all end at the point itself."""
    both = np.stack(shifts)
    return np.maximum(both.max(axis=0), 0.0) - np.minimum(both.min(axis=0), 0.0)

"""The wall as faces in space, and parallel views in which the half that faces the viewer is cut away."""

from dataclasses import dataclass

import numpy as np

from calibore.geometry import xy_of
from calibore.plotting._stations import Floats, Layout

YAW, ELEVATION = np.radians(32.0), np.radians(16.0)
AMBIENT, LIGHT = 0.50, np.array([0.20, 0.30, 0.93])
"""Share of light that comes from everywhere, and where the lamp is on the page: to the right, up, to the viewer."""


@dataclass(frozen=True)
class View:
    """A parallel view: `right`, `up`, `towards` are page axes in the pipe frame; a viewer at 3 h sees the 9 h half."""

    right: Floats
    up: Floats
    towards: Floats
    hour: int

    @staticmethod
    def of(side: int) -> "View":
        """Seen from the 3 h side and above (`side` +1), or from the 9 h side and below (-1): complementary halves."""
        level = side * np.cos(YAW), 0.0, -np.sin(YAW)
        towards = np.array([np.cos(ELEVATION) * level[0], -side * np.sin(ELEVATION), np.cos(ELEVATION) * level[2]])
        right = np.cross([0.0, -1.0, 0.0], towards)
        right /= np.linalg.norm(right)
        return View(right, np.cross(towards, right), towards, 9 if side > 0 else 3)

    def page(self, points: Floats) -> Floats:
        """Page coordinates (..., 2) of `points` (..., 3)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


@dataclass(frozen=True)
class Mesh:
    """Faces of the wall: `corners` (n, 4, 3) in nominal radii, `clock` (n,), `deviation` (n,), NaN where missing."""

    corners: Floats
    clock: Floats
    deviation: Floats

    def visible_from(self, view: View) -> np.ndarray:
        """Which faces (n,) show their inside to the viewer; the two views of `View.of` share them out."""
        x, y = xy_of(self.clock, 1.0)
        return x * view.towards[0] + y * view.towards[1] < 0

    def brightness(self, view: View) -> Floats:
        """Light on the inside of every face (n,), 0..1 (Lambert), lamp fixed to the viewer."""
        a, b = self.corners[:, 2] - self.corners[:, 0], self.corners[:, 3] - self.corners[:, 1]
        normal = np.cross(a, b)
        middle = self.corners.mean(axis=1)
        outward = np.sum(normal[:, :2] * middle[:, :2], axis=1, keepdims=True) > 0
        normal = np.where(outward, -normal, normal)
        size = np.linalg.norm(normal, axis=1)
        lamp = LIGHT[0] * view.right + LIGHT[1] * view.up + LIGHT[2] * view.towards
        facing = normal @ lamp / (np.linalg.norm(lamp) * np.where(size > 0, size, 1.0))
        return AMBIENT + (1 - AMBIENT) * np.clip(facing, 0, 1)


def mesh_of(layout: Layout, clock_edges: Floats, deviation: Floats, *, exaggeration: int, stretch: float) -> Mesh:
    """One face per column and clock row; `deviation` (column, row) in nominal radii, `stretch` radii per axis unit.

    Neighbours share their corners (means of the two sides) except across a gap between stations. A missing face lies on
    the nominal circle.
    """
    radius = 1 + exaggeration * np.nan_to_num(deviation)
    joined = layout.joined[:, None]
    between = (radius[1:] + radius[:-1]) / 2
    left = np.vstack([radius[:1], np.where(joined, between, radius[1:])])
    right = np.vstack([np.where(joined, between, radius[:-1]), radius[-1:]])
    middle = (layout.left[0] + layout.right[-1]) / 2
    rings = [
        _points(_at_row_edges(side), clock_edges, (edge - middle) * stretch)
        for side, edge in ((left, layout.left), (right, layout.right))
    ]
    near, far = rings
    corners = np.stack([near[:, :-1], near[:, 1:], far[:, 1:], far[:, :-1]], axis=2).reshape(-1, 4, 3)
    rows = np.broadcast_to((clock_edges[1:] + clock_edges[:-1]) / 2, deviation.shape)
    return Mesh(corners, rows.ravel(), deviation.ravel())


def _at_row_edges(radius: Floats) -> Floats:
    """Radius (column, row + 1) at the edges between clock rows, closed round the pipe."""
    edges = (radius + np.roll(radius, 1, axis=1)) / 2
    return np.hstack([edges, edges[:, :1]])


def _points(radius: Floats, clock: Floats, axial: Floats) -> Floats:
    x, y = xy_of(clock, radius)
    return np.stack([x, y, np.broadcast_to(axial[:, None], x.shape)], axis=-1)

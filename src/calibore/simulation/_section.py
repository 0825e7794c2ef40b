"""Where the laser surface meets the wall: a closed curve, followed by pipe clock."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose, xy_of
from calibore.lasers import Plane
from calibore.rigs import Rig
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

SETTLED = 1e-13  # m
MOST_ROUNDS = 60


@dataclass(frozen=True, eq=False)
class LaserPlane:
    """A rig's laser plane in the pipe frame: `normal` (3,), unit; points p with normal . p = `offset` [m]; `source`."""

    normal: Array
    offset: float
    source: Array

    @classmethod
    def of(cls, rig: Rig, pipe_from_rig: Pose, *, laser: int) -> "LaserPlane":
        surface = rig.lasers[laser].surface
        if not isinstance(surface, Plane):
            raise InputError(f"Only laser planes can be simulated, got a {type(surface).__name__}; use a Plane.")
        gradient = np.array([-surface.tilt_x, -surface.tilt_y, 1.0])
        source = pipe_from_rig.apply(np.array([0.0, 0.0, surface.baseline]))
        normal = pipe_from_rig.rotation @ (gradient / np.linalg.norm(gradient))
        if normal[2] < 0.1:
            raise InputError("The laser plane stands along the pipe and meets it in no ring; correct pose or tilt.")
        return cls(normal, float(normal @ source), source)

    def section(self, wall: PipeWall, clock: Array) -> Array:
        """The wall points (n, 3) of the pipe frame in this plane at pipe `clock` (n,) [rad]; NaN where unsettled.

        By turns the radius at the axial position and the axial position at the radius: the plane is steep and the
        wall flat, so each round gains at least a digit.
        """
        x, y = xy_of(clock, 1.0)
        lean = -(self.normal[0] * x + self.normal[1] * y) / self.normal[2]
        axial = np.full(clock.shape, self.offset / self.normal[2])
        change = np.zeros(clock.shape)
        for _ in range(MOST_ROUNDS):
            radius = wall.radius(axial, clock)
            moved = self.offset / self.normal[2] + lean * radius
            change, axial = np.abs(moved - axial), moved
            if change.max(initial=0.0) <= SETTLED:
                break
        else:
            axial = np.where(change <= SETTLED, axial, np.nan)
            radius = wall.radius(axial, clock)
        return np.stack([radius * x, radius * y, axial], axis=-1)


def wall_frame(wall: PipeWall, points: Array, clock: Array) -> tuple[Array, Array]:
    """The normal (n, 3) of the wall into the open, unit, and its tangent (n, 3) along the pipe per metre of z."""
    by_axial, by_clock = wall.slopes(points[:, 2], clock)
    sine, cosine = np.sin(clock), np.cos(clock)
    outward, round_ = np.stack([sine, -cosine]), np.stack([cosine, sine])
    radius = np.hypot(points[:, 0], points[:, 1])
    across = -outward + by_clock / radius * round_
    normal = np.column_stack([*across, by_axial])
    tangent = np.column_stack([*(by_axial * outward), np.ones_like(by_axial)])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True), tangent


def sees(wall: PipeWall, points: Array, eye: Array, *, normal: Array, steps: int = 24) -> NDArray[np.bool_]:
    """Which wall points (n, 3) can be seen from `eye` (3,), all in the pipe frame; `normal` (n, 3) into the open.

    The sight line is followed until it comes nearer to the pipe's axis than any part of the wall.
    """
    way = eye - points
    distance = np.linalg.norm(way, axis=1)
    way /= distance[:, None]
    seen = np.einsum("ij,ij->i", way, normal) > 0
    end = _open_from(points, way, distance, wall.clearance)
    place = (np.arange(1, steps + 1) / steps) ** 1.5  # densest at the start, where a steep face hides itself
    walked = points[seen, None, :] + (end[seen, None] * place)[..., None] * way[seen, None, :]
    seen[seen] = (wall.depth(walked) < 1e-8).all(axis=1)
    return seen


def _open_from(points: Array, way: Array, distance: Array, clearance: float) -> Array:
    """Length (n,) [m] of the sight lines before they enter the cylinder that no wall reaches into."""
    square = np.sum(way[:, :2] ** 2, axis=1)
    along = np.sum(points[:, :2] * way[:, :2], axis=1)
    over = np.sum(points[:, :2] ** 2, axis=1) - clearance**2
    root = along**2 - square * over
    enters = (root > 0) & (along < 0) & (square > 0)
    entry = (-along - np.sqrt(np.where(enters, root, 0.0))) / np.where(square > 0, square, 1.0)
    return np.where(enters, np.clip(entry, 0.0, distance), distance)

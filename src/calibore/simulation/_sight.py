"""Sight lines: the wall's normal, and which of its points an eye sees."""

import numpy as np
from numpy.typing import NDArray

from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]


def wall_normal(wall: PipeWall, points: Array, clock: Array) -> Array:
    """The normal (n, 3) of the wall into the open, unit, at its `points` (n, 3); all in the pipe frame."""
    by_axial, by_clock = wall.slopes(points[:, 2], clock)
    sine, cosine = np.sin(clock), np.cos(clock)
    outward, round_ = np.stack([sine, -cosine]), np.stack([cosine, sine])
    radius = np.hypot(points[:, 0], points[:, 1])
    across = -outward + by_clock / radius * round_
    normal = np.column_stack([*across, by_axial])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


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

"""Where a camera images a point, and what moves that place: the meeting of the pixel's own ray with the point.

With the ray X = o + s d of the pixel on which the point falls, and two unit vectors e across it, the point stays on
the ray where e . (dX - do - s dd) = 0. That gives d pixel for every lens, walking pupil and port alike.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from calibore.optics._camera import Camera

Array = NDArray[Any]


class Projection(NamedTuple):
    """Pixels `u`, `v` (n,) of n points; derivatives by the points (n, 2, 3) [px/m] and by p camera parameters
    (n, 2, p). NaN throughout for points that send the camera no ray.
    """

    u: Array
    v: Array
    by_point: Array
    by_parameters: Array


def project_with_sensitivities(camera: "Camera", points: ArrayLike) -> Projection:
    """Pixels of `points` (n, 3) in the camera frame with exact derivatives, parameters as `camera.parameter_names`."""
    points = np.asarray(points, dtype=float)
    u, v = camera.project(points)
    rays = camera.unproject_with_sensitivities(u, v)
    along = np.einsum("ni,ni->n", points - rays.origin, rays.direction)[:, None, None]
    across = _across(rays.direction)
    by_pixel = across @ (rays.origin_by_pixel + along * rays.direction_by_pixel)
    by_parameters = across @ (rays.origin_by_parameters + along * rays.direction_by_parameters)
    inverse = _inverse(by_pixel)
    return Projection(u, v, inverse @ across, -inverse @ by_parameters)


def _across(direction: Array) -> Array:
    """(n, 2, 3): two unit vectors across each `direction` (n, 3) and across each other."""
    least = np.eye(3)[np.argmin(np.abs(direction), axis=1)]
    first = np.cross(direction, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(direction, first)], axis=1)


def _inverse(matrix: Array) -> Array:
    """Of (n, 2, 2); NaN stays NaN, which `numpy.linalg.inv` would refuse."""
    (a, b), (c, d) = matrix[:, 0].T, matrix[:, 1].T
    adjugate = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], 1)
    return adjugate / (a * d - b * c)[:, None, None]

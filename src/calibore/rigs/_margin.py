"""How far a meeting is from where it ceases to exist, in standard uncertainties."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.rigs._rig import Rig
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]
LEAST = 1e-300  # curvature of a meeting that moves in proportion to everything: an infinite margin


def margin(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    branch: NDArray[np.intp],
    u_pixel: ArrayLike,
    direction: Array | None = None,
    laser: int = 0,
) -> Array:
    """How many standard uncertainties the meeting `branch` (n,) of each ray lies from first order's end (n,); NaN where
    there is none.

    The least of the distance to a fold, value / u(value), and 1 / |sum of second_order u(value) / value| over all
    frontiers, so that the relative second-order term of the propagation is 1 / (4 margin): first order holds from 4 on
    (docs/decisions/0005). `u_pixel` [px], a number or (n,): standard uncertainty of the pixel, along `direction`
    (n, 2), or of u and of v each where no direction is given.
    """
    u, v = np.atleast_1d(np.asarray(u, dtype=float)), np.atleast_1d(np.asarray(v, dtype=float))
    rays = rig.mount.place_with_sensitivities(rig.camera.unproject_with_sensitivities(u, v))
    surface = rig.lasers[laser].surface
    frontier = surface.frontier(rays.origin, rays.direction)
    variance = np.square(u_pixel)

    def chained(by_origin: Array, by_direction: Array) -> Array:
        """(k, n, p) derivatives of the frontiers by what moves the rays."""
        moved = np.einsum("kni,nip->knp", frontier.by_origin, by_origin)
        return moved + np.einsum("kni,nip->knp", frontier.by_direction, by_direction)

    by_pixel = chained(rays.origin_by_pixel, rays.direction_by_pixel)
    by_rays = chained(rays.origin_by_parameters, rays.direction_by_parameters)
    by_parameters = np.concatenate([rig.among_all(frontier.by_parameters, laser=laser), by_rays], axis=2)
    covariance = rig.covariance or Covariance.independent({})
    curvature, nearest = np.zeros(u.shape), np.full(u.shape, np.inf)
    for k, value in enumerate(frontier.value):
        common = propagate(by_parameters[k], covariance, names=rig.parameter_names).u
        spread = np.sqrt(common**2 + _noise(by_pixel[k], direction) * variance)
        bend = frontier.second_order[k][branch]
        concerns = (bend != 0) & (spread > 0) & ~np.isinf(value)
        away = np.where(concerns, value / np.where(concerns, spread, 1.0), np.inf)
        counts = concerns & (frontier.folds[k] | (value <= 0))
        nearest = np.where(counts, np.minimum(nearest, away), nearest)
        curvature += np.where(concerns & (value > 0), bend / np.where(value > 0, away, 1.0), 0.0)
    return np.minimum(nearest, 1 / np.maximum(np.abs(curvature), LEAST))


def _noise(by_pixel: Array, direction: Array | None) -> Array:
    if direction is None:
        return np.einsum("nk,nk->n", by_pixel, by_pixel)
    return np.einsum("nk,nk->n", by_pixel, direction) ** 2

"""How far a meeting is from where it ceases to exist, in standard uncertainties."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.rigs._rig import Rig
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]


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
    """The margin frontier / u(frontier) (n,) of the meeting `branch` (n,) of each ray; NaN where there is
    none.

    `u_pixel` [px], a number or (n,): standard uncertainty of the pixel, along `direction` (n, 2), or of u and of v each
    where no direction is given. The relative second-order term of the propagation is 1 / (4 margin), for every surface:
    first order holds from 4 on (docs/decisions/0005).
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
    margins = np.full(frontier.value.shape, np.inf)
    for k, value in enumerate(frontier.value):
        common = propagate(by_parameters[k], covariance, names=rig.parameter_names).u
        noise = _noise(by_pixel[k], direction)
        spread = np.sqrt(common**2 + noise * variance)
        weight = frontier.second_order[k][branch]
        counts = (weight > 0) & (spread > 0) & ~np.isinf(value)
        margins[k] = np.where(counts, value / np.where(counts, weight * spread, 1.0), np.inf)
    return np.asarray(margins.min(axis=0))


def _noise(by_pixel: Array, direction: Array | None) -> Array:
    if direction is None:
        return np.einsum("nk,nk->n", by_pixel, by_pixel)
    return np.einsum("nk,nk->n", by_pixel, direction) ** 2

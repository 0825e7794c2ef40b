"""Millions of pixels to wall points with uncertainty: the compiled form of `triangulate` and `propagate`."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore._native import measure_points
from calibore.errors import InputError
from calibore.kernels import DEFAULT_KERNEL
from calibore.lasers import Cone
from calibore.rigs import _engine as native
from calibore.rigs._arguments import check_choice, check_noise, pixels_of
from calibore.rigs._rig import Rig
from calibore.rigs._triangulation import Sensitivities, triangulate
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]
ROWS = 7


@dataclass(frozen=True, eq=False)
class Measured:
    """n wall points: `radius`, `axial` [m], `clock` [rad], their standard uncertainty [m] and `status`; rows whose
    status carries no value are NaN.

    Independent from point to point: the noise of the pixels. Common to all points: the parameters of the rig.
    """

    radius: Array
    axial: Array
    clock: Array
    u_radius_independent: Array
    u_radius_common: Array
    u_axial_independent: Array
    u_axial_common: Array
    status: NDArray[np.uint8]

    @cached_property
    def u_radius(self) -> Array:
        return np.hypot(self.u_radius_independent, self.u_radius_common)

    @cached_property
    def u_axial(self) -> Array:
        return np.hypot(self.u_axial_independent, self.u_axial_common)


def measure(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    u_pixel: ArrayLike,
    laser: int = 0,
    prior_radius: ArrayLike | None = None,
    branch: ArrayLike | None = None,
    direction: ArrayLike | None = None,
    kernel: str = DEFAULT_KERNEL,
    threads: int | None = None,
) -> Measured:
    """Wall points of the pixels `u`, `v` (n,) on `laser`, to first order in pixel and rig.

    `u_pixel` [px], a number or (n,): standard uncertainty of the pixel, along `direction` (n, 2), or of u and of v each
    where none is given. `prior_radius`, `branch`: see `triangulate`. `threads`: all cores where None. Lenses and mounts
    that the compiled engine does not know are computed in NumPy.
    """
    check_choice(rig, laser, prior_radius, branch)
    u, v = (np.ascontiguousarray(a, dtype=float) for a in np.broadcast_arrays(*pixels_of(u, v)))
    noise, directions = native.each(u_pixel, u.size, what="u_pixel"), native.columns(direction, u.size)
    check_noise(noise)
    if not native.computes(kernel, rig, laser):
        return _by_numpy(rig, u, v, noise, directions, laser=laser, prior_radius=prior_radius, branch=branch)
    choice = choice_of(rig, u.size, laser=laser, prior_radius=prior_radius, branch=branch)
    rows, status = np.empty((ROWS, u.size)), np.empty(u.size, dtype=np.uint8)
    known = native.known_of(rig, laser)
    measure_points(*known, u, v, choice, noise, directions, threads or 0, rows, status)
    return _of_rows(rows, status)


def _of_rows(rows: Array, status: NDArray[np.uint8]) -> Measured:
    return Measured(rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], status)


def choice_of(
    rig: Rig, n: int, *, laser: int, prior_radius: ArrayLike | None, branch: ArrayLike | None
) -> tuple[bool, Array]:
    """Whether meetings are told by number, and the numbers; else the radii near which they are."""
    if branch is not None:
        return True, native.each(branch, n, what="branch")
    if prior_radius is not None:
        return False, native.each(prior_radius, n, what="prior_radius")
    if isinstance(rig.lasers[laser].surface, Cone):
        raise InputError(
            "A camera ray can meet this laser surface twice; pass prior_radius, the radius the wall has roughly, or "
            "branch, to say which meeting counts."
        )
    return True, np.zeros(1)


def _by_numpy(
    rig: Rig, u: Array, v: Array, noise: Array, directions: tuple[Array, Array] | None, **meeting: Any
) -> Measured:
    points = triangulate(rig, u, v, **meeting)
    covariance = rig.covariance or Covariance.independent({})

    def parts(sensitivities: Sensitivities) -> tuple[Array, Array]:
        by_pixel = sensitivities.pixel
        slope = np.linalg.norm(by_pixel, axis=1) if directions is None else np.abs(_along(by_pixel, directions))
        common = propagate(sensitivities.parameters, covariance, names=points.parameter_names).u
        return slope * noise, np.where(np.isnan(slope), np.nan, common)

    radius, axial = parts(points.radius_sensitivities), parts(points.axial_sensitivities)
    return Measured(points.radius, points.axial, points.clock, *radius, *axial, points.status)


def _along(by_pixel: Array, directions: tuple[Array, Array]) -> Array:
    return by_pixel[:, 0] * directions[0] + by_pixel[:, 1] * directions[1]

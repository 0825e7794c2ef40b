"""The heart: a camera ray meets a laser surface; uncertainty by implicit differentiation at the meeting."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import clock_of
from calibore.lasers import MeetingFlag
from calibore.optics import RaysWithSensitivities
from calibore.rigs._arguments import check_choice, pixels_of
from calibore.rigs._candidates import Candidates, candidates_along, nearest_branch
from calibore.rigs._rig import Rig
from calibore.status import Status

Array = NDArray[np.float64]


class Sensitivities(NamedTuple):
    """Derivatives of one coordinate by the pixel (n, 2) and by the parameters (n, p)."""

    pixel: NDArray[Any]
    parameters: NDArray[Any]


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Wall points in the rig frame; rows whose `status` carries no value are NaN throughout.

    `points` (n, 3) [m]; `status` (n,) uint8; `d_pixel` (n, 3, 2) [m/px]; `d_parameters` (n, 3, p) [m per SI or px] in
    the order of `parameter_names`; `branch` (n,) which of the surface's meetings it is.
    """

    points: NDArray[Any]
    status: NDArray[np.uint8]
    d_pixel: NDArray[Any]
    d_parameters: NDArray[Any]
    parameter_names: tuple[str, ...]
    branch: NDArray[np.intp]

    @cached_property
    def radius(self) -> NDArray[Any]:
        """(n,) [m] from the rig axis."""
        return np.hypot(self.points[:, 0], self.points[:, 1])

    @cached_property
    def clock(self) -> NDArray[Any]:
        """(n,) [rad]."""
        return clock_of(self.points[:, 0], self.points[:, 1])

    @cached_property
    def axial(self) -> NDArray[Any]:
        """(n,) [m] along the rig axis."""
        return self.points[:, 2]

    @cached_property
    def radius_sensitivities(self) -> Sensitivities:
        """With dR = (x dx + y dy) / R; NaN on the axis, where the radius has no slope."""
        x, y, radius = self._off_axis
        return self._along(x / radius, y / radius)

    @cached_property
    def clock_sensitivities(self) -> Sensitivities:
        """With d clock = (x dy - y dx) / R^2."""
        x, y, radius = self._off_axis
        return self._along(-y / radius**2, x / radius**2)

    @cached_property
    def axial_sensitivities(self) -> Sensitivities:
        return Sensitivities(self.d_pixel[:, 2], self.d_parameters[:, 2])

    @property
    def _off_axis(self) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        return self.points[:, 0], self.points[:, 1], np.where(self.radius > 0, self.radius, np.nan)

    def _along(self, x: NDArray[Any], y: NDArray[Any]) -> Sensitivities:
        x, y = x[:, None], y[:, None]
        by_pixel, by_parameters = self.d_pixel, self.d_parameters
        return Sensitivities(x * by_pixel[:, 0] + y * by_pixel[:, 1], x * by_parameters[:, 0] + y * by_parameters[:, 1])


def triangulate(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    laser: int = 0,
    prior_radius: ArrayLike | None = None,
    branch: ArrayLike | None = None,
) -> Triangulation:
    """Where the camera rays through the pixels `u`, `v` (n,) meet the surface of `laser`.

    Where a ray meets the surface more than once (cones), the meeting whose radius is nearest to `prior_radius` [m], a
    number or (n,), counts, or the one that `branch` (n,) names. With X = o + d u and F(X; q) = 0:
    dX = do + d du + u dd, dd = -(grad F . (do + d du) + F_q dq) / (grad F . u).
    NaN pixels come back as NO_PEAK, other unusable ones as OUTSIDE_LENS, GRAZING or BEHIND.
    """
    check_choice(rig, laser, prior_radius, branch)
    u, v = pixels_of(u, v)
    rays = rig.mount.place_with_sensitivities(rig.camera.unproject_with_sensitivities(u, v))
    candidates = candidates_along(rays, rig.lasers[laser].surface)
    branch = _branch(candidates, prior_radius, branch)
    status = _status(np.isnan(u) | np.isnan(v), np.isnan(rays.direction[:, 2]), candidates.flags_of(branch))
    distance = np.where(status == Status.OK, candidates.distance_of(branch), np.nan)
    points, d_pixel, d_parameters = _meeting(rig, rays, distance, laser)
    return Triangulation(points, status, d_pixel, d_parameters, rig.parameter_names, branch)


def _meeting(rig: Rig, rays: RaysWithSensitivities, distance: NDArray[Any], laser: int) -> tuple[NDArray[Any], ...]:
    """Points (n, 3) at `distance` (n,) along `rays`, and their derivatives by pixel and by parameters."""
    surface = rig.lasers[laser].surface
    points = rays.origin + distance[:, None] * rays.direction
    gradient = surface.gradient(points)
    along = rays.direction / np.einsum("ni,ni->n", gradient, rays.direction)[:, None]

    def move(by_origin: Array, by_direction: Array) -> NDArray[Any]:
        """Where the meeting of a moving ray goes: its motion, less the part that would leave the surface."""
        shift = by_origin + distance[:, None, None] * by_direction
        leaving = np.einsum("ni,nip->np", gradient, shift)
        return shift - along[:, :, None] * leaving[:, None, :]

    by_surface = -along[:, :, None] * surface.parameter_gradient(points)[:, None, :]
    by_rays = move(rays.origin_by_parameters, rays.direction_by_parameters)
    d_parameters = np.concatenate([rig.among_all(by_surface, laser=laser), by_rays], axis=2)
    return points, move(rays.origin_by_pixel, rays.direction_by_pixel), d_parameters


def _branch(candidates: Candidates, prior_radius: ArrayLike | None, branch: ArrayLike | None) -> NDArray[np.intp]:
    if branch is not None:
        return np.broadcast_to(np.asarray(branch, dtype=np.intp), candidates.radius.shape[1:])
    if candidates.branches == 1:
        return np.zeros(candidates.radius.shape[1], dtype=np.intp)
    if prior_radius is None:
        raise InputError(
            "A camera ray can meet this laser surface twice; pass prior_radius, the radius the wall has roughly, or "
            "branch, to say which meeting counts."
        )
    return nearest_branch(candidates, np.asarray(prior_radius, dtype=float))


def _status(no_pixel: NDArray[np.bool_], no_ray: NDArray[np.bool_], flags: NDArray[np.uint8]) -> NDArray[np.uint8]:
    status = np.full(flags.shape, Status.OK, dtype=np.uint8)
    status[(flags & MeetingFlag.BEHIND) != 0] = Status.BEHIND
    status[((flags & MeetingFlag.GRAZING) != 0) | (flags == MeetingFlag.NONE)] = Status.GRAZING
    status[no_ray] = Status.OUTSIDE_LENS
    status[no_pixel] = Status.NO_PEAK
    return status

"""The heart: a camera ray meets a laser surface; uncertainty by implicit differentiation at the meeting."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.geometry import clock_of
from calibore.lasers import MeetingFlag, Meetings
from calibore.rigs._rig import Rig
from calibore.status import Status

PUPIL = np.zeros(3)  # rays leave the entrance pupil, which is the origin of the rig frame


class Sensitivities(NamedTuple):
    """Derivatives of one coordinate by the pixel (n, 2) and by the parameters (n, p)."""

    pixel: NDArray[Any]
    parameters: NDArray[Any]


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Wall points in the rig frame; rows whose `status` carries no value are NaN throughout.

    `points` (n, 3) [m]; `status` (n,) uint8; `d_pixel` (n, 3, 2) [m/px]; `d_parameters` (n, 3, p) [m per SI or px] in
    the order of `parameter_names`.
    """

    points: NDArray[Any]
    status: NDArray[np.uint8]
    d_pixel: NDArray[Any]
    d_parameters: NDArray[Any]
    parameter_names: tuple[str, ...]

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


def triangulate(rig: Rig, u: ArrayLike, v: ArrayLike, *, laser: int = 0) -> Triangulation:
    """Where the camera rays through the pixels `u`, `v` (n,) meet the surface of `laser`.

    With X = o + d u and F(X; q) = 0: dX = do + d du + u dd, dd = -(grad F . (do + d du) + F_q dq) / (grad F . u); here
    do = 0. NaN pixels come back as NO_PEAK, other unusable ones as OUTSIDE_LENS, GRAZING or BEHIND.
    """
    u, v = np.atleast_1d(np.asarray(u) * 1.0), np.atleast_1d(np.asarray(v) * 1.0)
    surface = rig.lasers[laser].surface
    directions, d_pixel, d_camera = rig.camera.unproject_with_sensitivities(u, v)
    meetings = surface.meet(PUPIL, directions)
    status = _status(np.isnan(u) | np.isnan(v), np.isnan(directions[:, 2]), meetings)
    distance = meetings.distance[0]
    directions = np.where((status == Status.OK)[:, None], directions, np.nan)
    points = PUPIL + distance[:, None] * directions
    gradient = surface.gradient(points)
    closing = np.einsum("ni,ni->n", gradient, directions)
    along = directions / closing[:, None]

    def move(d_directions: NDArray[Any]) -> NDArray[Any]:
        """The d du + u dd of turning rays: the turn, less its part that would leave the surface."""
        turn = distance[:, None, None] * d_directions
        leaving = np.einsum("ni,nip->np", gradient, turn)
        return turn - along[:, :, None] * leaving[:, None, :]

    d_surface = -along[:, :, None] * surface.parameter_gradient(points)[:, None, :]
    d_parameters = np.concatenate([d_surface, move(d_camera)], axis=2)
    return Triangulation(points, status, move(d_pixel), d_parameters, rig.parameter_names(laser))


def _status(no_pixel: NDArray[np.bool_], no_ray: NDArray[np.bool_], meetings: Meetings) -> NDArray[np.uint8]:
    flags = meetings.flags[0]
    status = np.full(flags.shape, Status.OK, dtype=np.uint8)
    status[(flags & MeetingFlag.BEHIND) != 0] = Status.BEHIND
    status[(flags & MeetingFlag.GRAZING) != 0] = Status.GRAZING
    status[no_ray] = Status.OUTSIDE_LENS
    status[no_pixel] = Status.NO_PEAK
    return status

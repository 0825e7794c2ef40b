"""The perpendicular plane, which may be tilted: z = baseline + tilt_x x + tilt_y y (formats.md, section 1)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers._surface import GRAZING_SINE, LaserSurface, MeetingFlag, Meetings


@dataclass(frozen=True)
class Plane(LaserSurface):
    """`baseline` [m] along the camera axis; `tilt_x`, `tilt_y`: slopes, 0 when perpendicular."""

    baseline: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0

    parameter_names: ClassVar[tuple[str, ...]] = ("baseline", "tilt_x", "tilt_y")

    def __post_init__(self) -> None:
        if not 0 < self.baseline < np.inf:
            raise InputError(
                f"The baseline must be positive, got {self.baseline} m; the laser plane stands ahead of the camera."
            )
        if not np.isfinite([self.tilt_x, self.tilt_y]).all():
            raise InputError(f"Tilts are finite slopes, got {self.tilt_x} and {self.tilt_y}; 0 means perpendicular.")

    def value(self, points: NDArray[Any]) -> NDArray[Any]:
        x, y, z = points.T
        return z - self.baseline - self.tilt_x * x - self.tilt_y * y

    def gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        return np.broadcast_to(self._gradient, points.shape)

    def parameter_gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        return np.stack([np.full_like(points[:, 0], -1), -points[:, 0], -points[:, 1]]).T

    def meet(self, origins: NDArray[Any], directions: NDArray[Any]) -> Meetings:
        """One meeting per ray. Swanbom 2007, eq. 4-9, in tilts instead of its singular angles."""
        x, y, z = directions.T
        slope = z - self.tilt_x * x - self.tilt_y * y
        height = -self.value(np.atleast_2d(origins))
        parallel = slope == 0
        distance = np.where(parallel, np.inf, height / np.where(parallel, 1, slope))
        grazing = np.abs(slope) < GRAZING_SINE * np.linalg.norm(self._gradient)
        flags = np.where(np.isnan(slope), MeetingFlag.NONE, MeetingFlag.NEAR).astype(np.uint8)
        flags |= np.where(grazing, MeetingFlag.GRAZING, MeetingFlag.NONE).astype(np.uint8)
        flags |= np.where(np.real(distance) <= 0, MeetingFlag.BEHIND, MeetingFlag.NONE).astype(np.uint8)
        return Meetings(distance[None], flags[None])

    @property
    def _gradient(self) -> NDArray[Any]:
        return np.array([-self.tilt_x, -self.tilt_y, 1.0])

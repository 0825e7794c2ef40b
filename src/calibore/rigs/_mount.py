"""Where the camera stands in the rig: the pose `rig_from_camera`, as a function of named parameters."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.optics import Rays, RaysWithSensitivities


class Mount(ABC):
    """`rotation` (3, 3) and `translation` (3,) [m] with p_rig = rotation @ p_camera + translation.

    `gradient`: their derivatives (q, 3, 3) and (q, 3) by the q parameters `parameter_names`.
    """

    parameter_names: ClassVar[tuple[str, ...]] = ()

    @property
    @abstractmethod
    def rotation(self) -> NDArray[Any]: ...

    @property
    @abstractmethod
    def translation(self) -> NDArray[Any]: ...

    @abstractmethod
    def gradient(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

    def place(self, rays: Rays) -> Rays:
        """`rays` of the camera frame in the rig frame."""
        return Rays(rays.origin @ self.rotation.T + self.translation, rays.direction @ self.rotation.T)

    def place_with_sensitivities(self, rays: RaysWithSensitivities) -> RaysWithSensitivities:
        """The same, with what moves them; the mount's parameters stand before the camera's."""
        rotation = self.rotation
        by_rotation, by_translation = self.gradient()
        turned = (rotation @ part for part in rays[2:])
        origin_by_pixel, direction_by_pixel, origin_by_camera, direction_by_camera = turned
        origin_by_mount = np.einsum("qij,nj->niq", by_rotation, rays.origin) + by_translation.T
        direction_by_mount = np.einsum("qij,nj->niq", by_rotation, rays.direction)
        return RaysWithSensitivities(
            *self.place(Rays(rays.origin, rays.direction)),
            origin_by_pixel,
            direction_by_pixel,
            np.concatenate([origin_by_mount, origin_by_camera], axis=2),
            np.concatenate([direction_by_mount, direction_by_camera], axis=2),
        )

    def camera_points(self, points: NDArray[Any]) -> NDArray[Any]:
        """`points` (n, 3) of the rig frame in the camera frame."""
        return (points - self.translation) @ self.rotation


@dataclass(frozen=True)
class Forward(Mount):
    """A forward-looking rig: its frame is the camera's."""

    @property
    def rotation(self) -> NDArray[Any]:
        return np.eye(3)

    @property
    def translation(self) -> NDArray[Any]:
        return np.zeros(3)

    def gradient(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.zeros((0, 3, 3)), np.zeros((0, 3))

    def place(self, rays: Rays) -> Rays:
        return rays

    def place_with_sensitivities(self, rays: RaysWithSensitivities) -> RaysWithSensitivities:
        return rays


@dataclass(frozen=True)
class SideFacing(Mount):
    """A camera on a rotating head (formats.md, section 1; Swanbom 2007, eqs. 5-1 to 5-16).

    Its pupil stands `baseline` [m] from the laser sheet, its axis at `aim` [rad] from the sheet and towards it. Head
    frame: y radially outwards, z along travel; in the image +u is larger range and -v is +z.
    """

    baseline: float
    aim: float

    parameter_names: ClassVar[tuple[str, ...]] = ("baseline", "aim")

    def __post_init__(self) -> None:
        if not 0 < self.baseline < np.inf:
            raise InputError(
                f"The baseline must be positive, got {self.baseline} m; it is the camera's distance from the sheet."
            )
        if not 0 <= self.aim < np.pi / 2:
            raise InputError(
                f"The aim of a side-facing camera must lie in 0 ... 90 deg, got {np.degrees(self.aim):.6g} deg; "
                "it is the angle from the laser sheet to the camera's axis."
            )

    @property
    def rotation(self) -> NDArray[Any]:
        sine, cosine = np.sin(self.aim), np.cos(self.aim)
        return np.array([[cosine, 0 * sine, -sine], [sine, 0 * sine, cosine], [0 * sine, -1 + 0 * sine, 0 * sine]])

    @property
    def translation(self) -> NDArray[Any]:
        return np.array([self.baseline, 0 * self.baseline, 0 * self.baseline])

    def gradient(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        sine, cosine = np.sin(self.aim), np.cos(self.aim)
        by_aim = np.array([[-sine, 0, -cosine], [cosine, 0, -sine], [0, 0, 0]])
        return np.stack([np.zeros((3, 3)), by_aim]), np.array([[1.0, 0, 0], [0, 0, 0]])


FORWARD = Forward()

"""Rigid motions between frames, written `a_from_b`: `points_a = a_from_b.apply(points_b)`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

ORTHOGONAL_WITHIN = 1e-9  # rounding of a product of many rotations


@dataclass(frozen=True, eq=False)
class Pose:
    """`a_from_b`: rotation (3, 3) and translation (3,) [m], so that `p_a = rotation @ p_b + translation`."""

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def __post_init__(self) -> None:
        rotation = np.array(self.rotation, dtype=float)
        translation = np.array(self.translation, dtype=float)
        if rotation.shape != (3, 3) or translation.shape != (3,):
            raise InputError(
                f"A pose needs a rotation of shape (3, 3) and a translation of shape (3,), "
                f"got {rotation.shape} and {translation.shape}; use Pose.from_roll_pitch_yaw()."
            )
        if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
            raise InputError("A pose must be finite, got NaN or infinity; leave out stations whose pose is unknown.")
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > ORTHOGONAL_WITHIN or np.linalg.det(rotation) < 0:
            raise InputError(
                "A pose's rotation must be orthogonal with determinant +1 (right-handed frames); "
                "use Pose.from_roll_pitch_yaw()."
            )
        rotation.flags.writeable = translation.flags.writeable = False
        object.__setattr__(self, "rotation", rotation)
        object.__setattr__(self, "translation", translation)

    @classmethod
    def identity(cls) -> "Pose":
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def from_roll_pitch_yaw(
        cls, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0, *, translation: ArrayLike = (0.0, 0.0, 0.0)
    ) -> "Pose":
        """Roll first (about z, clockwise looking along travel), then pitch (about x, nose up), then yaw (about y, nose
        right), all about the axes of frame a: `rotation = R_y(yaw) R_x(pitch) R_z(roll)`. Angles [rad].
        """
        (sin_r, sin_p, sin_y), (cos_r, cos_p, cos_y) = np.sin([roll, pitch, yaw]), np.cos([roll, pitch, yaw])
        about_z = np.array([[cos_r, -sin_r, 0.0], [sin_r, cos_r, 0.0], [0.0, 0.0, 1.0]])
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, cos_p, -sin_p], [0.0, sin_p, cos_p]])
        about_y = np.array([[cos_y, 0.0, sin_y], [0.0, 1.0, 0.0], [-sin_y, 0.0, cos_y]])
        return cls(about_y @ about_x @ about_z, np.asarray(translation, dtype=float))

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 3) of frame b in frame a."""
        return np.asarray(points) @ self.rotation.T + self.translation

    def inverse(self) -> "Pose":
        """`b_from_a`."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def __matmul__(self, other: "Pose") -> "Pose":
        """`a_from_b @ b_from_c` is `a_from_c`."""
        return Pose(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

"""How one profile lies in the frame of another."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """Takes points of the moving profile's frame into the reference's.

    Radii are multiplied by `scale`, lengths along the axis from `pivot` [m] by 1 + `stretch`; the axis is inclined by
    the slopes `tilt_x`, `tilt_y` about the pivot on it, all is turned by `roll` [rad] (positive: to larger clocks) and
    moved by `shift_x`, `shift_y`, `axial` [m].
    """

    roll: float = 0.0
    shift_x: float = 0.0
    shift_y: float = 0.0
    axial: float = 0.0
    stretch: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    scale: float = 1.0
    pivot: float = 0.0

    names: ClassVar[tuple[str, ...]] = (
        "roll",
        "shift_x",
        "shift_y",
        "axial",
        "stretch",
        "tilt_x",
        "tilt_y",
        "scale",
    )

    @property
    def values(self) -> Array:
        """(8,) in the order of `names`."""
        return np.array([getattr(self, name) for name in self.names])

    def with_values(self, values: Array) -> "Motion":
        return replace(self, **dict(zip(self.names, map(float, values), strict=True)))

    @property
    def rotation(self) -> Array:
        """(3, 3): inclined, then turned."""
        return _about_z(self.roll) @ _inclined(self.tilt_x, self.tilt_y)

    def apply(self, points: Array) -> Array:
        """`points` (n, 3) of the moving frame in the reference's."""
        return self._stretched(points) @ self.rotation.T + self._place

    def apply_with_slopes(self, points: Array) -> tuple[Array, Array]:
        """The same, and its derivatives (n, 3, 8) by the parameters, exact for tilts that are small."""
        before = self._stretched(points)
        turn, lean = _about_z(self.roll), _inclined(self.tilt_x, self.tilt_y)
        rotation = turn @ lean
        moved = before @ rotation.T
        slopes = np.zeros((*points.shape, len(self.names)))
        slopes[:, 0, 0], slopes[:, 1, 0] = -moved[:, 1], moved[:, 0]
        slopes[:, 0, 1] = slopes[:, 1, 2] = slopes[:, 2, 3] = 1.0
        slopes[:, :, 4] = np.outer(points[:, 2] - self.pivot, rotation[:, 2])
        leaned = before @ lean.T
        for column, (i, j) in ((5, (0, 2)), (6, (1, 2))):
            by_tilt = np.zeros_like(leaned)
            by_tilt[:, i], by_tilt[:, j] = leaned[:, 2], -leaned[:, i]
            slopes[:, :, column] = by_tilt @ turn.T
        across = points * np.array([1.0, 1.0, 0.0])
        slopes[:, :, 7] = across @ rotation.T
        return moved + self._place, slopes

    @property
    def _place(self) -> Array:
        return np.array([self.shift_x, self.shift_y, self.axial + self.pivot])

    def _stretched(self, points: Array) -> Array:
        factor = np.array([self.scale, self.scale, 1 + self.stretch])
        return (points - np.array([0.0, 0.0, self.pivot])) * factor

    def about(self, pivot: float) -> "Motion":
        """The same motion, described about another `pivot` [m]."""
        on_axis = self.apply(np.array([[0.0, 0.0, pivot]]))[0]
        return replace(self, pivot=pivot, shift_x=on_axis[0], shift_y=on_axis[1], axial=on_axis[2] - pivot)


def _about_z(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _inclined(tilt_x: float, tilt_y: float) -> Array:
    """The rotation that takes the z axis to the direction (tilt_x, tilt_y, 1) the short way (Rodrigues)."""
    forward = np.array([tilt_x, tilt_y, 1.0]) / np.sqrt(1 + tilt_x**2 + tilt_y**2)
    v = np.array([-forward[1], forward[0], 0.0])
    skew = np.array([[0.0, 0.0, v[1]], [0.0, 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1 + forward[2])

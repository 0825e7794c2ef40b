"""A flat target of concentric rings and spokes before a camera: where on it a point of its plane lies."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.lasers import Plane

Array = NDArray[np.float64]


class Place(NamedTuple):
    """A length (n,) [m] on the target; derivatives by the point (n, 3) and by `RingTarget.parameter_names` (n, 6)."""

    value: Array
    by_point: Array
    by_parameters: Array


@dataclass(frozen=True)
class RingTarget:
    """The target lies in the plane z = baseline + tilt_x x + tilt_y y of the camera frame; its centre is over
    (`centre_x`, `centre_y`) [m], its first spoke turned by `roll` [rad] from the camera's x towards its y.
    """

    baseline: float
    tilt_x: float
    tilt_y: float
    centre_x: float
    centre_y: float
    roll: float

    parameter_names: ClassVar[tuple[str, ...]] = ("baseline", "tilt_x", "tilt_y", "centre_x", "centre_y", "roll")

    @property
    def plane(self) -> Plane:
        return Plane(self.baseline, self.tilt_x, self.tilt_y)

    def point(self, radius: Array, angle: Array) -> Array:
        """Points (n, 3) of the camera frame at `radius` [m] and `angle` [rad] from the first spoke."""
        length, stretch = self._lengths
        along, across = radius * np.cos(angle + self.roll), radius * np.sin(angle + self.roll)
        y = across * length / stretch
        x = (along * length - self.tilt_x * self.tilt_y * y) / length**2
        x, y = x + self.centre_x, y + self.centre_y
        return np.stack([x, y, self.baseline + self.tilt_x * x + self.tilt_y * y], axis=1)

    def off_centre(self, points: Array) -> Array:
        """(n,) [m]: the value of `radius` alone."""
        x, y, rise = self._from_centre(points)
        return np.sqrt(x * x + y * y + rise * rise)

    def off_spoke(self, points: Array, angle: Array) -> Array:
        """(n,) [m]: the value of `across` alone."""
        x, y, rise = self._from_centre(points)
        a, b = self._lengths
        return np.cos(angle + self.roll) * y * b / a - np.sin(angle + self.roll) * (x + self.tilt_x * rise) / a

    def radius(self, points: Array) -> Place:
        """Distance from the centre of `points` (n, 3) of the plane."""
        x, y, rise = self._from_centre(points)
        radius = np.sqrt(x * x + y * y + rise * rise)
        to_x, to_y = (x + self.tilt_x * rise) / radius, (y + self.tilt_y * rise) / radius
        none = np.zeros_like(radius)
        by_parameters = [none, x * rise / radius, y * rise / radius, -to_x, -to_y, none]
        return Place(radius, np.stack([to_x, to_y, none], 1), np.stack(by_parameters, 1))

    def across(self, points: Array, angle: Array) -> Place:
        """Distance from the spoke at `angle` (n,) [rad] from the first one, positive towards greater angles.

        With e1 = (1, 0, tilt_x) / a in the plane and e2 across it, a point is at ((x + tilt_x rise) / a, y b / a),
        a = sqrt(1 + tilt_x^2), b = sqrt(1 + tilt_x^2 + tilt_y^2).
        """
        x, y, rise = self._from_centre(points)
        a, b = self._lengths
        first, second = (x + self.tilt_x * rise) / a, y * b / a
        cosine, sine = np.cos(angle + self.roll), np.sin(angle + self.roll)
        to_x = -sine * (1 + self.tilt_x**2) / a
        to_y = -sine * self.tilt_x * self.tilt_y / a + cosine * b / a
        by_tilt_x = -sine * ((rise + self.tilt_x * x) / a - first * self.tilt_x / a**2)
        by_tilt_x += cosine * second * (self.tilt_x / b**2 - self.tilt_x / a**2)
        by_tilt_y = -sine * self.tilt_x * y / a + cosine * second * self.tilt_y / b**2
        none = np.zeros_like(x)
        by_roll = -cosine * first - sine * second
        return Place(
            cosine * second - sine * first,
            np.stack([to_x, to_y, none], 1),
            np.stack([none, by_tilt_x, by_tilt_y, -to_x, -to_y, by_roll], 1),
        )

    @property
    def _lengths(self) -> tuple[float, float]:
        return np.sqrt(1 + self.tilt_x**2), np.sqrt(1 + self.tilt_x**2 + self.tilt_y**2)

    def _from_centre(self, points: Array) -> tuple[Array, Array, Array]:
        x, y = points[:, 0] - self.centre_x, points[:, 1] - self.centre_y
        return x, y, self.tilt_x * x + self.tilt_y * y

"""A camera: pixel to ray, with exact sensitivities, and point to pixel.

Camera frame: origin at the entrance pupil, x right, y down, z along the optical axis. Pixel (0, 0) is the centre of
the top-left pixel; (u, v) = (column, row).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.optics._lens import Lens


@dataclass(frozen=True)
class Camera:
    """`width`, `height` [px]; `principal_point` (u, v) [px]; `aspect`: v scale over u scale of the pixels."""

    width: int
    height: int
    lens: Lens
    principal_point: tuple[float, float]
    aspect: float = 1.0

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise InputError(f"An image must be at least 1 x 1 px, got {self.width} x {self.height} px.")
        if not np.isfinite(self.principal_point).all():
            raise InputError(f"The principal point must be finite pixels (u, v), got {self.principal_point}.")
        if not 0 < self.aspect < np.inf:
            raise InputError(f"Pixel aspect must be positive, got {self.aspect}; 1 means square pixels.")

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Dotted paths of the parameters of `unproject_with_sensitivities`, in its order."""
        names = (*self.lens.parameter_names, "aspect", "principal_point_u", "principal_point_v")
        return tuple(f"camera.{name}" for name in names)

    def unproject(self, u: ArrayLike, v: ArrayLike) -> NDArray[Any]:
        """Unit directions (n, 3) of the rays through pixels `u`, `v` (n,); NaN outside the lens's range."""
        cosine, sine, radius, _ = self._polar(u, v)
        zenith = self.lens.zenith(radius)
        return self._direction(zenith, cosine, sine).T

    def unproject_with_sensitivities(
        self, u: ArrayLike, v: ArrayLike
    ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Directions (n, 3), their derivatives by the pixel (n, 3, 2) [1/px] and by `parameter_names` (n, 3, p).

        With the azimuth a = atan2(y, x) in the image, d direction = e_zenith d zenith + sin(zenith) e_azimuth d a.
        """
        cosine, sine, radius, y = self._polar(u, v)
        zenith, by_radius, by_lens = self.lens.zenith_with_sensitivities(radius)
        direction = self._direction(zenith, cosine, sine)
        sin_zenith, cos_zenith = np.sin(zenith), direction[2]
        e_zenith = np.stack([cos_zenith * cosine, cos_zenith * sine, -sin_zenith])
        e_azimuth = np.stack([-sine, cosine, np.zeros_like(sine)])
        across = np.where(radius != 0, sin_zenith / np.where(radius != 0, radius, 1), by_radius)
        by_x = e_zenith * (by_radius * cosine) - e_azimuth * (across * sine)
        by_y = e_zenith * (by_radius * sine) + e_azimuth * (across * cosine)
        by_u, by_v = by_x, by_y / self.aspect
        by_parameters = [e_zenith * slope for slope in by_lens]
        by_parameters += [by_y * (-y / self.aspect), -by_u, -by_v]
        return direction.T, np.stack([by_u, by_v]).transpose(2, 1, 0), np.stack(by_parameters).transpose(2, 1, 0)

    def project(self, points: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Pixels u, v (n,) of points (n, 3) in the camera frame; NaN for points outside the lens's range."""
        x, y, z = np.asarray(points).T
        off_axis = np.sqrt(x * x + y * y)
        zenith = np.arctan2(off_axis, z)
        scale = self.lens.image_radius(zenith) / np.where(off_axis > 0, off_axis, 1)
        return self.principal_point[0] + scale * x, self.principal_point[1] + self.aspect * scale * y

    def _polar(self, u: ArrayLike, v: ArrayLike) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Cosine and sine of the image azimuth (from +u towards +v), image radius [px], and its v part [px]."""
        x = np.asarray(u) - self.principal_point[0]
        y = (np.asarray(v) - self.principal_point[1]) / self.aspect
        radius = np.sqrt(x * x + y * y)
        divisor = np.where(radius != 0, radius, 1)
        return np.where(radius != 0, x / divisor, 1), y / divisor, radius, y

    @staticmethod
    def _direction(zenith: NDArray[Any], cosine: NDArray[Any], sine: NDArray[Any]) -> NDArray[Any]:
        sin_zenith = np.sin(zenith)
        return np.stack([sin_zenith * cosine, sin_zenith * sine, np.cos(zenith)])

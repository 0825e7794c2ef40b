"""A camera: pixel to ray, with exact sensitivities, and point to pixel.

Camera frame: origin at the entrance pupil (of the axial ray, where the pupil walks), x right, y down, z along the
optical axis. Pixel (0, 0) is the centre of the top-left pixel; (u, v) = (column, row).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.optics._lens import Lens
from calibore.optics._port import FlatPort
from calibore.optics._projection import Projection, project_with_sensitivities
from calibore.optics._pupil import Pupil
from calibore.optics._rays import Rays, RaysWithSensitivities

FARTHEST = 1e6  # [px] a principal point; and an aspect: beyond any camera, and its square is still a number
WIDEST_WALK = 1.0  # [m]; more is millimetres given as metres


@dataclass(frozen=True)
class Camera:
    """`width`, `height` [px]; `principal_point` (u, v) [px]; `aspect`: v scale over u scale of the pixels.

    `pupil_walk` (d2, d4, ...) [m]: the entrance pupil of a ray lies at z = d2 zenith^2 + d4 zenith^4 + ...; `port`: a
    window between pupil and scene.
    """

    width: int
    height: int
    lens: Lens
    principal_point: tuple[float, float]
    aspect: float = 1.0
    pupil_walk: tuple[float, ...] = ()
    port: FlatPort | None = None

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise InputError(f"An image must be at least 1 x 1 px, got {self.width} x {self.height} px.")
        if not (np.abs(self.principal_point) <= FARTHEST).all():
            raise InputError(
                f"The principal point must be finite pixels (u, v) near the image, got {self.principal_point}."
            )
        if not 1 / FARTHEST <= self.aspect <= FARTHEST:
            raise InputError(f"Pixel aspect must be positive, got {self.aspect}; 1 means square pixels.")
        if not all(abs(coefficient) <= WIDEST_WALK for coefficient in self.pupil_walk):
            raise InputError(
                f"Pupil walk coefficients must lie within {WIDEST_WALK:g} m, got {self.pupil_walk}; "
                "give them in metres (per rad^2, per rad^4, ...)."
            )

    @cached_property
    def _pupil(self) -> Pupil | None:
        return Pupil(self.pupil_walk, self.port) if self.pupil_walk or self.port else None

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Dotted paths of the parameters of `unproject_with_sensitivities`, in its order."""
        names = (*self.lens.parameter_names, "aspect", "principal_point_u", "principal_point_v")
        return tuple(f"camera.{name}" for name in (*names, *(self._pupil.parameter_names if self._pupil else ())))

    def unproject(self, u: ArrayLike, v: ArrayLike) -> Rays:
        """Rays through pixels `u`, `v` (n,); NaN directions outside the lens's range and past a port's."""
        cosine, sine, radius, _ = self._polar(u, v)
        zenith = self.lens.zenith(radius)
        if self._pupil is None:
            direction = _direction(np.sin(zenith), np.cos(zenith), cosine, sine).T
            return Rays(np.zeros(direction.shape), direction)
        crossing, sin_zenith, cos_zenith = self._pupil.depart(zenith)
        return Rays(_along_axis(crossing), _direction(sin_zenith, cos_zenith, cosine, sine).T)

    def unproject_with_sensitivities(self, u: ArrayLike, v: ArrayLike) -> RaysWithSensitivities:
        """The rays, and their derivatives by the pixel and by `parameter_names`.

        With the azimuth a = atan2(y, x) in the image and the zenith beyond the port,
        d direction = e_zenith d zenith + sin(zenith) e_azimuth d a; the origin moves along the axis only.
        """
        image = self._polar(u, v)
        zenith, by_radius, by_lens = self.lens.zenith_with_sensitivities(image[2])
        if self._pupil is None:
            directions = self._directions(image, np.sin(zenith), np.cos(zenith), by_radius, by_lens, [])
            return _with_origins([np.zeros(part.shape) for part in directions], directions)
        crossing, sin_zenith, cos_zenith = self._pupil.depart(zenith)
        slopes = self._pupil.slopes(zenith)
        bend, along = slopes.zenith_by_zenith, slopes.crossing_by_zenith
        by_lens_beyond = [bend * slope for slope in by_lens]
        directions = self._directions(
            image, sin_zenith, cos_zenith, bend * by_radius, by_lens_beyond, slopes.zenith_by_parameters
        )
        by_x, by_y = (along * by_radius * part for part in image[:2])
        by_pixel, by_parameters = self._chain(by_x, by_y, image[3], [along * slope for slope in by_lens])
        by_parameters += slopes.crossing_by_parameters
        origins = crossing, np.stack(by_pixel, -1), np.stack(by_parameters, -1)
        return _with_origins([_along_axis(part) for part in origins], directions)

    def project(self, points: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Pixels u, v (n,) of points (n, 3) in the camera frame; NaN for points that send it no ray."""
        x, y, z = np.asarray(points).T
        off_axis = np.sqrt(x * x + y * y)
        if self._pupil is None:
            zenith = np.arctan2(off_axis, z)
        else:
            zenith = self._pupil.zenith(off_axis, z, max_zenith=self.lens.max_zenith)
        scale = self.lens.image_radius(zenith) / np.where(off_axis > 0, off_axis, 1)
        return self.principal_point[0] + scale * x, self.principal_point[1] + self.aspect * scale * y

    def project_with_sensitivities(self, points: ArrayLike) -> Projection:
        """The pixels, and their derivatives by the points and by `parameter_names`."""
        return project_with_sensitivities(self, points)

    def _polar(self, u: ArrayLike, v: ArrayLike) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Cosine and sine of the image azimuth (from +u towards +v), image radius [px], and its v part [px]."""
        x = np.asarray(u) - self.principal_point[0]
        y = (np.asarray(v) - self.principal_point[1]) / self.aspect
        radius = np.sqrt(x * x + y * y)
        divisor = np.where(radius != 0, radius, 1)
        return np.where(radius != 0, x / divisor, 1), y / divisor, radius, y

    def _directions(
        self,
        image: tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]],
        sin_zenith: NDArray[Any],
        cos_zenith: NDArray[Any],
        by_radius: NDArray[Any],
        by_lens: list[NDArray[Any]],
        by_pupil: list[NDArray[Any]],
    ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Directions (n, 3), by the pixel (n, 3, 2) and by the parameters (n, 3, p), from the slopes of the zenith."""
        cosine, sine, radius, y = image
        direction = _direction(sin_zenith, cos_zenith, cosine, sine)
        e_zenith = np.stack([cos_zenith * cosine, cos_zenith * sine, -sin_zenith])
        e_azimuth = np.stack([-sine, cosine, np.zeros_like(sine)])
        across = np.where(radius != 0, sin_zenith / np.where(radius != 0, radius, 1), by_radius)
        by_x = e_zenith * (by_radius * cosine) - e_azimuth * (across * sine)
        by_y = e_zenith * (by_radius * sine) + e_azimuth * (across * cosine)
        pixel, parameters = self._chain(by_x, by_y, y, [e_zenith * slope for slope in by_lens])
        parameters += [e_zenith * slope for slope in by_pupil]
        return direction.T, np.stack(pixel).transpose(2, 1, 0), np.stack(parameters).transpose(2, 1, 0)

    def _chain(
        self, by_x: NDArray[Any], by_y: NDArray[Any], y: NDArray[Any], by_lens: list[NDArray[Any]]
    ) -> tuple[list[NDArray[Any]], list[NDArray[Any]]]:
        """By the pixel, and by lens, aspect and principal point, from what moves with the place x, y in the image."""
        by_v = by_y / self.aspect
        return [by_x, by_v], [*by_lens, by_y * (-y / self.aspect), -by_x, -by_v]


def _direction(
    sin_zenith: NDArray[Any], cos_zenith: NDArray[Any], cosine: NDArray[Any], sine: NDArray[Any]
) -> NDArray[Any]:
    return np.stack([sin_zenith * cosine, sin_zenith * sine, cos_zenith])


def _along_axis(z: NDArray[Any]) -> NDArray[Any]:
    """Vectors (0, 0, z) for `z` (n, ...), as (n, 3, ...)."""
    vectors = np.zeros((z.shape[0], 3, *z.shape[1:]), z.dtype)
    vectors[:, 2] = z
    return vectors


def _with_origins(origins: list[NDArray[Any]], directions: tuple[NDArray[Any], ...]) -> RaysWithSensitivities:
    """Value, by pixel and by parameters of both, in the order of the tuple."""
    return RaysWithSensitivities(*(part for pair in zip(origins, directions, strict=True) for part in pair))

"""A flat port: the plane-parallel plate of a camera housing, and the ray that has passed it.

With S, C = sin, cos(zenith), N^2 = n^2 - S^2 for the plate and M^2 = m^2 - S^2 for the medium beyond (Snell), a ray
from `start` on the axis leaves along (S, M) / m, and its line crosses the axis at
start M/C + distance (1 - M/C) + thickness (1 - M/N). No term is 0/0 on the axis.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

GRAZING = 1 - 1e-12  # of the zenith at which a ray no longer passes
LEAST_INDEX, GREATEST_INDEX = 0.9, 5.0  # relative to the air behind the port; below 1 only by uncertainty
THICKEST, FARTHEST = 1.0, 10.0  # [m]; more is millimetres given as metres


class Passage(NamedTuple):
    """S, C, N and M of rays, each (n,); NaN where a ray does not pass the port."""

    sine: NDArray[Any]
    cosine: NDArray[Any]
    plate: NDArray[Any]
    medium: NDArray[Any]


@dataclass(frozen=True)
class FlatPort:
    """A plate across the camera axis, its inner face `distance` [m] ahead of the camera's origin.

    `thickness` [m]; `index` of the plate and `medium_index` of what lies beyond it (1 air, 1.333 water), both relative
    to the air behind the port.
    """

    thickness: float
    index: float
    distance: float = 0.0
    medium_index: float = 1.0
    parameter_names: ClassVar[tuple[str, ...]] = ("thickness", "index", "distance", "medium_index")

    def __post_init__(self) -> None:
        for name, most in (("thickness", THICKEST), ("distance", FARTHEST)):
            if not 0 <= getattr(self, name) <= most:
                raise InputError(
                    f"Port {name} must be 0 to {most:g} m, got {getattr(self, name)} m; give it in metres, "
                    "or leave the port out."
                )
        for name in ("index", "medium_index"):
            if not LEAST_INDEX <= getattr(self, name) <= GREATEST_INDEX:
                raise InputError(
                    f"Port {name} must be {LEAST_INDEX} to {GREATEST_INDEX:g}, got {getattr(self, name)}; "
                    "air is 1, water 1.333, glass about 1.5."
                )

    @property
    def outer_face(self) -> float:
        """How far ahead [m] of the camera's origin the medium begins."""
        return self.distance + self.thickness

    @property
    def max_zenith(self) -> float:
        """The zenith [rad] in front of the port up to which rays pass."""
        return float(np.arcsin(min(1.0, np.real(self.index), np.real(self.medium_index)))) * GRAZING

    def passage(self, zenith: NDArray[Any]) -> Passage:
        cosine = np.cos(zenith)
        plate = (self.index - 1) * (self.index + 1) + cosine * cosine
        medium = (self.medium_index - 1) * (self.medium_index + 1) + cosine * cosine
        passes = (np.real(cosine) > 0) & (np.real(plate) > 0) & (np.real(medium) > 0)
        sine, cosine, plate, medium = (
            np.where(passes, part, np.nan) for part in (np.sin(zenith), cosine, plate, medium)
        )
        return Passage(sine, cosine, np.sqrt(plate), np.sqrt(medium))

    def crossing(self, passage: Passage, start: NDArray[Any]) -> NDArray[Any]:
        """Where on the axis [m] the refracted ray's line crosses it, for rays from `start` (n,) on the axis."""
        _, cosine, plate, medium = passage
        deeper = medium / cosine
        return start * deeper + self.distance * (1 - deeper) + self.thickness * (1 - medium / plate)

    def crossing_by_zenith(self, passage: Passage, start: NDArray[Any]) -> NDArray[Any]:
        """The derivative of `crossing` by the zenith in front of the port at a fixed `start`."""
        sine, cosine, plate, medium = passage
        n, m = self.index, self.medium_index
        by_walls = (start - self.distance) * (m - 1) * (m + 1) / (cosine * cosine)
        return sine / medium * (by_walls - self.thickness * cosine * (m - n) * (m + n) / plate**3)

    def crossing_by_parameters(self, passage: Passage, start: NDArray[Any]) -> list[NDArray[Any]]:
        """The derivatives of `crossing` by `parameter_names` at a fixed zenith and `start`."""
        _, cosine, plate, medium = passage
        by_index = self.thickness * medium * self.index / plate**3
        by_medium = ((start - self.distance) / cosine - self.thickness / plate) * self.medium_index / medium
        return [1 - medium / plate, by_index, 1 - medium / cosine, by_medium]

    def miss(
        self, zenith: NDArray[Any], *, start: NDArray[Any], off_axis: NDArray[Any], ahead: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """How far inside points (off_axis, ahead) rays pass, times C; and its derivative at a fixed `start`."""
        sine, cosine, plate, medium = self.passage(zenith)
        n, m = self.index, self.medium_index
        beyond, behind = ahead - self.outer_face, self.distance - start
        through = self.thickness * cosine / plate + beyond * cosine / medium
        by_plate = (cosine**2 * plate**2 - sine**2 * (n - 1) * (n + 1)) / plate**3
        by_medium = (cosine**2 * medium**2 - sine**2 * (m - 1) * (m + 1)) / medium**3
        slope = -off_axis * sine - behind * cosine - self.thickness * by_plate - beyond * by_medium
        return off_axis * cosine - sine * (behind + through), slope

"""The perpendicular plane, which may be tilted: z = baseline + tilt_x x + tilt_y y (formats.md, section 1)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers._flat import FlatSurface
from calibore.lasers._possible import MOST, possible


@dataclass(frozen=True)
class Plane(FlatSurface):
    """`baseline` [m] along the camera axis; `tilt_x`, `tilt_y`: slopes, 0 when perpendicular.

    Swanbom 2007, eq. 4-9, in tilts instead of its singular angles.
    """

    baseline: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0

    parameter_names: ClassVar[tuple[str, ...]] = ("baseline", "tilt_x", "tilt_y")

    def __post_init__(self) -> None:
        if not 0 < self.baseline <= MOST:
            raise InputError(
                f"The baseline must be positive, got {self.baseline} m; the laser plane stands ahead of the camera."
            )
        if not possible([self.tilt_x, self.tilt_y]):
            raise InputError(f"Tilts are finite slopes, got {self.tilt_x} and {self.tilt_y}; 0 means perpendicular.")

    @property
    def normal(self) -> NDArray[Any]:
        return np.array([-self.tilt_x, -self.tilt_y, 1.0])

    @property
    def level(self) -> Any:
        return self.baseline

    @property
    def normal_by_parameters(self) -> NDArray[Any]:
        return np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])

    @property
    def level_by_parameters(self) -> NDArray[Any]:
        return np.array([1.0, 0.0, 0.0])

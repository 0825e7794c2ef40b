"""Water at the invert: what is under it is not seen, and its surface shows the lit wall upside down."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

STRAIGHT_DOWN = 0.02  # share that water returns of light that falls on it upright


@dataclass(frozen=True)
class Water:
    """Turbid water that stands `level` [m] above the lowest point of the nominal wall. Its waves have slopes of
    `ripple` [rad] (standard deviation); at every stop about `glints` of them send laser light straight into the camera.
    """

    level: float
    ripple: float = 0.01
    glints: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0 < self.level < np.inf:
            raise InputError(f"Water must stand above the invert, got a level of {self.level:g} m; leave it out.")
        if not (0 <= self.ripple < 0.5 and 0 <= self.glints < 1000):
            raise InputError(
                f"Waves need a slope below 0.5 rad and less than 1000 glints, got {self.ripple:g} rad and "
                f"{self.glints:g}; neither may be negative."
            )

    def surface(self, nominal_radius: float) -> float:
        """Height of the surface as y [m] of the pipe frame, downwards."""
        return nominal_radius - self.level

    def covers(self, points: Array, nominal_radius: float) -> NDArray[np.bool_]:
        """Which `points` (n, 3) of the pipe frame lie under water."""
        return points[:, 1] > self.surface(nominal_radius)

    def mirrored(self, points: Array, nominal_radius: float) -> Array:
        """`points` (..., 3) of the pipe frame as the surface shows them."""
        return points * [1.0, -1.0, 1.0] + [0.0, 2 * self.surface(nominal_radius), 0.0]


def returned_share(cosine: Array) -> Array:
    """Light (n,) that water returns by the cosine of the angle to its normal: Fresnel's, as Schlick approximates it."""
    return STRAIGHT_DOWN + (1 - STRAIGHT_DOWN) * (1 - cosine) ** 5

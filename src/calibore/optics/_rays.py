"""Camera rays: where they start and where they go, and what moves them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class Rays(NamedTuple):
    """n rays X = origin + distance x direction in the camera frame: `origin` (n, 3) [m], `direction` (n, 3) unit."""

    origin: NDArray[Any]
    direction: NDArray[Any]


class RaysWithSensitivities(NamedTuple):
    """`Rays` and their derivatives by the pixel (n, 3, 2) [1/px, m/px] and by p camera parameters (n, 3, p)."""

    origin: NDArray[Any]
    direction: NDArray[Any]
    origin_by_pixel: NDArray[np.float64]
    direction_by_pixel: NDArray[np.float64]
    origin_by_parameters: NDArray[np.float64]
    direction_by_parameters: NDArray[np.float64]

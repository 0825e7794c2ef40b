"""Clock positions: the angle round the pipe from the crown, clockwise looking along travel.

Axes are x right, y down, z forward: 12 o'clock is -y, 3 o'clock +x, 6 o'clock +y, 9 o'clock -x.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FULL_TURN = 2 * np.pi


def clock_of(x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
    """Clock [rad] in [0, 2 pi) of the points (x, y); any shape. The inverse of `xy_of`."""
    clock = np.mod(np.arctan2(x, np.negative(y)), FULL_TURN)
    return np.where(clock >= FULL_TURN, 0.0, clock)  # mod rounds a tiny negative angle up to a full turn


def xy_of(clock: ArrayLike, radius: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    """`x = R sin(clock)`, `y = -R cos(clock)` in the unit of `radius`; shapes broadcast."""
    radius = np.asarray(radius)
    return radius * np.sin(clock), -radius * np.cos(clock)

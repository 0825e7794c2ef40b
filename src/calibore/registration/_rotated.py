"""A ring turned by a fractional number of clock positions, as the dissertation does it (Swanbom 2007, eq. 8-3)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def rotated(radius: ArrayLike, positions: float) -> NDArray[np.float64]:
    """`radius` (..., m) turned by `positions` clock positions to larger clocks: the whole part shifts, the rest a
    (0 <= a < 1) mixes neighbours: R'[i] = (1 - a) R[i] + a R[i - 1].

    It shrinks independent noise by sqrt((1 - a)^2 + a^2), 0.71 at a = 0.5: compare profiles with `register` instead.
    """
    radius = np.asarray(radius, dtype=float)
    whole = int(np.floor(positions))
    a = positions - whole
    shifted = np.roll(radius, whole, axis=-1)
    return (1 - a) * shifted + a * np.roll(shifted, 1, axis=-1)

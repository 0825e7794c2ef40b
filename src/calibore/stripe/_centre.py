"""Where the ring's centre lies: the area centroid of the detected line."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]


def area_centroid(column: Array, row: Array) -> tuple[float, float]:
    """Centroid of the polygon through the points in their order (Swanbom 2007, eqs. 6-11 and 6-12, Green's theorem).

    Right for either sense of rotation; the polygon closes itself, with chords across gaps.
    """
    if column.size < 3:
        raise InputError(f"An area centroid needs at least 3 points, got {column.size}.")
    x0, y0 = column.mean(), row.mean()
    x, y = column - x0, row - y0
    xn, yn = np.roll(x, -1), np.roll(y, -1)
    area = 0.5 * np.sum((y + yn) * (xn - x))
    if abs(area) < 1e-9:
        raise InputError("The points enclose no area, so they have no area centroid.")
    moment_x = -np.sum((yn - y) * (x**2 + x * xn + xn**2)) / 6
    moment_y = np.sum((xn - x) * (y**2 + y * yn + yn**2)) / 6
    return float(x0 + moment_x / area), float(y0 + moment_y / area)


def in_sectors(azimuth: Array, sectors: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Which image azimuths (n,) [rad] lie in one of the `sectors`, each (from, to) [rad] with rising azimuth."""
    inside = np.zeros(azimuth.shape, dtype=bool)
    for begin, end in sectors:
        if not np.isfinite(begin) or not np.isfinite(end):
            raise InputError(f"An alignment sector must be two finite azimuths in rad, got ({begin}, {end}).")
        inside |= np.mod(azimuth - begin, 2 * np.pi) <= np.mod(end - begin, 2 * np.pi)
    return inside

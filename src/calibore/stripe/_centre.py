"""Where the ring's centre lies: the area centroid of the detected line; of an open arc, the centre of its circle.

The centre only says where the rays start from; what is measured does not depend on it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.units import LARGEST

Array = NDArray[np.float64]
WIDEST_GAP = 1 / 3
"""Of the turn."""
LEAST_BEND = 1e-9
"""Least determinant of the points' scatter, relative to its diagonal, that shows a bend."""


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


def ring_centre(column: Array, row: Array, seen: NDArray[np.bool_]) -> tuple[float, float]:
    """Centre of the line at (column, row) (n,) [px] on the rays `seen` (n,), rays in order round the ring.

    Its area centroid; but where more than `WIDEST_GAP` of the turn is missing, the chord across it would pull that
    centroid off the ring, and the circle through the points (least squares of x^2 + y^2, Kasa 1976) tells better.
    Raises InputError where the points have no such centre.
    """
    index = np.flatnonzero(seen)
    widest = int(np.max(np.diff(np.append(index, index[0] + seen.size))))
    if widest > WIDEST_GAP * seen.size:
        return circle_centre(column[index], row[index])
    return area_centroid(column[index], row[index])


def circle_centre(column: Array, row: Array) -> tuple[float, float]:
    """Centre of the circle through points (n,), by least squares of its algebraic equation."""
    x0, y0 = column.mean(), row.mean()
    x, y = column - x0, row - y0
    square = x**2 + y**2
    xx, xy, yy, xs, ys = np.sum(x * x), np.sum(x * y), np.sum(y * y), np.sum(x * square), np.sum(y * square)
    determinant = xx * yy - xy**2
    if determinant <= LEAST_BEND * xx * yy:
        raise InputError("The points lie on a straight line, so they are on no circle.")
    a, b = (xs * yy - ys * xy) / (2 * determinant), (ys * xx - xs * xy) / (2 * determinant)
    return float(x0 + a), float(y0 + b)


def in_sectors(azimuth: Array, sectors: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Which image azimuths (n,) [rad] lie in one of the `sectors`, each (from, to) [rad] with rising azimuth."""
    inside = np.zeros(azimuth.shape, dtype=bool)
    for begin, end in sectors:
        if not (abs(begin) <= LARGEST["angle"] and abs(end) <= LARGEST["angle"]):
            raise InputError(f"An alignment sector must be two azimuths [rad] within some turns, got ({begin}, {end}).")
        inside |= np.mod(azimuth - begin, 2 * np.pi) <= np.mod(end - begin, 2 * np.pi)
    return inside

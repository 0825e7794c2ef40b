"""A kernel in Numba: every ray sampled and fitted in one loop, nothing stored but a window of eight samples."""

import math

import numpy as np
from numba import njit

from benchmarks.peers.opencv_warp_polar import RAYS, THRESHOLD, WINDOW, centroid

MIDDLE, HALF = (WINDOW - 1) / 2, WINDOW // 2
GATE = 0.8
"""Of the threshold: windows whose middle sample is darker are not worth a fit."""
SQUARES = sum((k - MIDDLE) ** 2 for k in range(WINDOW))
MEAN_SQUARE = SQUARES / WINDOW
FOURTHS = sum(((k - MIDDLE) ** 2 - MEAN_SQUARE) ** 2 for k in range(WINDOW))


@njit(fastmath=True)
def _vertex(window, first):
    """Place and height of the parabola fitted to the window whose oldest sample is `first`; height -1 for none."""
    slope, bend, mean = 0.0, 0.0, 0.0
    for k in range(WINDOW):
        value, lever = window[(first + k) % WINDOW], k - MIDDLE
        slope += lever * value
        bend += (lever * lever - MEAN_SQUARE) * value
        mean += value
    slope, bend, mean = slope / SQUARES, bend / FOURTHS, mean / WINDOW
    if bend >= 0.0 or abs(slope) > -bend:
        return 0.0, -1.0
    offset = -slope / (2.0 * bend)
    return offset, mean + slope * offset + bend * (offset * offset - MEAN_SQUARE)


@njit(fastmath=True)
def radii(plane, centre_u, centre_v, inner, outer, threshold):
    """(rays,) radius of the highest vertex on each ray [px], NaN for none; `plane` (h, w) uint8."""
    height, width = plane.shape
    found, window = np.full(RAYS, np.nan), np.zeros(WINDOW)
    for ray in range(RAYS):
        azimuth = ray * (2.0 * math.pi / RAYS)
        du, dv, best, filled = math.cos(azimuth), math.sin(azimuth), threshold, 0
        for radius in range(inner, outer):
            u, v = centre_u + radius * du, centre_v + radius * dv
            if u < 0.0 or v < 0.0 or u >= width - 1 or v >= height - 1:
                filled = 0
                continue
            left, top = int(u), int(v)
            x, y = u - left, v - top
            upper = plane[top, left] * (1.0 - x) + plane[top, left + 1] * x
            lower = plane[top + 1, left] * (1.0 - x) + plane[top + 1, left + 1] * x
            window[radius % WINDOW] = upper * (1.0 - y) + lower * y
            filled += 1
            if filled >= WINDOW and window[(radius - HALF) % WINDOW] > GATE * threshold:
                offset, peak = _vertex(window, (radius + 1) % WINDOW)
                if peak > best:
                    best = peak
                    found[ray] = radius - MIDDLE + offset
    return found


@njit(fastmath=True)
def rows(plane, threshold):
    """(h,) column of the highest vertex of each row [px], NaN for none."""
    height, width = plane.shape
    found, window = np.full(height, np.nan), np.zeros(WINDOW)
    for row in range(height):
        best = threshold
        for column in range(width):
            window[column % WINDOW] = plane[row, column]
            if column >= WINDOW - 1 and window[(column - HALF) % WINDOW] > GATE * threshold:
                offset, peak = _vertex(window, (column + 1) % WINDOW)
                if peak > best:
                    best = peak
                    found[row] = column - MIDDLE + offset
    return found


def ring(image: np.ndarray, centre: tuple[float, float], inner: float, outer: float, band: int):
    """(u, v) of the ring, NaN where not found; re-centred on the area centroid to 0.5 px like the other peers."""
    plane = np.ascontiguousarray(image[:, :, band])
    azimuth = np.arange(RAYS) * (2 * np.pi / RAYS)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    for _ in range(8):
        radius = radii(plane, centre[0], centre[1], int(inner), int(np.ceil(outer)), THRESHOLD)
        u, v = centre[0] + radius * cos, centre[1] + radius * sin
        found = np.isfinite(u)
        moved = centroid(u[found], v[found])
        shift = np.hypot(moved[0] - centre[0], moved[1] - centre[1])
        if shift < 0.5:
            break
        centre = moved
    return u, v


def line(image: np.ndarray, band: int) -> np.ndarray:
    """(h,) column of the line in every row."""
    return rows(np.ascontiguousarray(image[:, :, band]), THRESHOLD)

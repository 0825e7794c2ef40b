"""Steger's line detector (IEEE TPAMI 20(2), 1998): ridges of the smoothed picture, where the slope across them is zero.

The Hessian of the picture smoothed with sigma gives the direction n across the line; the line runs through a pixel
where t n, t = -(g . n) / (n . H n), stays within it. Points are not linked: the strongest on each ray or row counts.
"""

import cv2
import numpy as np

from benchmarks.peers.opencv_warp_polar import RAYS

SIGMA = 2.0
"""px; above half the line's width over sqrt(3), where its ridge is single."""
LEAST_BEND = 3.0
"""Grey values / px^2 across the line, below which nothing counts as one."""
WITHIN = 0.6
"""px from the middle of a pixel; t is a little long there, and half a pixel would leave gaps."""
WIDEST_GAP = 3.0
"""Rays over which points are joined."""


def _kernels() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x = np.arange(-int(4 * SIGMA), int(4 * SIGMA) + 1.0)
    smooth = np.exp(-(x**2) / (2 * SIGMA**2))
    smooth /= smooth.sum()
    return smooth, x / SIGMA**2 * smooth, (x**2 / SIGMA**4 - 1 / SIGMA**2) * smooth


SMOOTH, SLOPE, BEND = _kernels()


def points(plane: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """u, v [px] and strength (the bend across) of all line points of `plane` (h, w)."""
    picture = plane.astype(np.float32)

    def by(along_u: np.ndarray, along_v: np.ndarray) -> np.ndarray:
        return cv2.sepFilter2D(picture, cv2.CV_32F, along_u, along_v)

    uu, vv, uv = by(BEND, SMOOTH), by(SMOOTH, BEND), by(SLOPE, SLOPE)
    across = 0.5 * (uu + vv) - np.sqrt(0.25 * (uu - vv) ** 2 + uv**2)
    row, column = np.nonzero(across < -LEAST_BEND)
    slope = by(SLOPE, SMOOTH)[row, column], by(SMOOTH, SLOPE)[row, column]
    uu, vv, uv, across = uu[row, column], vv[row, column], uv[row, column], across[row, column]
    angle = 0.5 * np.arctan2(2 * uv, uu - vv) + np.pi / 2  # of the eigenvector with the more negative bend
    nu, nv = np.cos(angle), np.sin(angle)
    t = -(slope[0] * nu + slope[1] * nv) / across
    here = (np.abs(t * nu) <= WITHIN) & (np.abs(t * nv) <= WITHIN)
    return column[here] + (t * nu)[here], row[here] + (t * nv)[here], -across[here]


def ring(image: np.ndarray, centre: tuple[float, float], inner: float, outer: float, band: int):
    """(u, v) on `RAYS` rays from `centre`: the strongest point of each, joined over short gaps; NaN where wide."""
    left, top = (max(int(c - outer), 0) for c in centre)
    plane = image[top : int(centre[1] + outer) + 1, left : int(centre[0] + outer) + 1, band]
    u, v, strength = points(plane)
    du, dv = u + left - centre[0], v + top - centre[1]
    radius, place = np.hypot(du, dv), np.arctan2(dv, du) * (RAYS / (2 * np.pi)) % RAYS
    inside = (radius >= inner) & (radius < outer)
    radius, place, strength = radius[inside], place[inside], strength[inside]
    strongest = np.lexsort((-strength, place.astype(int)))
    _, first = np.unique(place[strongest].astype(int), return_index=True)
    kept = strongest[first]
    radius, place = radius[kept], place[kept]
    order = np.argsort(place)
    rays = np.arange(RAYS)
    found = np.interp(rays, place[order], radius[order], period=RAYS)
    after = place[order][np.searchsorted(place[order], rays) % order.size]
    before = place[order][np.searchsorted(place[order], rays) - 1]
    found[(after - before) % RAYS > WIDEST_GAP] = np.nan
    azimuth = rays * (2 * np.pi / RAYS)
    return centre[0] + found * np.cos(azimuth), centre[1] + found * np.sin(azimuth)


def line(image: np.ndarray, band: int) -> np.ndarray:
    """(h,) column of the strongest point of every row, NaN for none."""
    u, v, strength = points(image[:, :, band])
    row = np.rint(v).astype(int)
    found = np.full(len(image), np.nan)
    order = np.argsort(strength)
    found[np.clip(row[order], 0, len(image) - 1)] = u[order]  # the strongest comes last
    return found

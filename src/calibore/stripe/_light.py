"""Laser light or other light: told by how wide a peak is and what colour it has."""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import Peaks
from calibore.stripe._picture import Picture
from calibore.stripe._rays import Rays

Array = NDArray[np.float64]
WIDEST = 3.0
"""Light wider than this many line widths is not the laser line."""
FOREIGN = 0.35
"""A peak whose other colours exceed its own by this much more than the line's typically do is not laser light."""


def laser_light(picture: Picture, rays: Rays, peaks: Peaks, width: float) -> NDArray[np.bool_]:
    """Which candidates (n, k) look like laser light: about as wide as the line of `width` [px], and of its colour."""
    laser = np.isfinite(peaks.position) & (peaks.width <= WIDEST * width)
    if not picture.is_colour or not laser.any():
        return laser
    share = foreign_share(picture, rays, peaks)
    return laser & ~(share > np.median(share[laser]) + FOREIGN)


def foreign_share(picture: Picture, rays: Rays, peaks: Peaks) -> Array:
    """Brightest other colour over the own colour, both above the own colour's background; (n, k)."""
    column, row = rays.at(np.where(np.isfinite(peaks.position), peaks.position, 0.0))
    height, width = picture.image.shape[:2]
    c, r = (np.clip(np.floor(a + 0.5), 0, n - 1).astype(np.intp) for a, n in ((column, width), (row, height)))
    pixel = picture.image[r, c].astype(np.float64)
    others = [band for band in range(3) if band != picture.band]
    own = np.maximum(pixel[:, :, picture.band] - peaks.background, 1.0)
    return (pixel[:, :, others].max(axis=2) - peaks.background) / own

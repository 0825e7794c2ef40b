"""An image prepared for scanning: which colour is looked at, and where white is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, UsageError
from calibore.stripe._rays import ONE, Rays

Array = NDArray[np.float64]
SMALLEST = 8
"""Least width and height [px] of an image in which a line can be measured."""
CHANNELS = {"red": 0, "green": 1, "blue": 2, "luma": 3}
PART = 1 << 16
"""Parts of a pixel between which brightness is interpolated: places are rounded down by up to 1.5e-5 px."""
LUMA = np.array([299, 587, 114])
"""Luma in thousandths of red, green, blue (ITU-R BT.601), as JPEG and video use it."""


@dataclass(frozen=True)
class Picture:
    """`image` (h, w) or (h, w, 3), uint8 or uint16, C-contiguous, and the `channel` of it that is looked at."""

    image: NDArray[np.generic]
    channel: str

    @property
    def is_colour(self) -> bool:
        """Whether other colours can tell laser light from other light."""
        return self.image.ndim == 3 and self.channel != "luma"

    @property
    def band(self) -> int:
        """Number of the band: 0 to 2, or 3 for the luma of all three; 0 for grey images."""
        return 0 if self.image.ndim == 2 else CHANNELS[self.channel]

    @property
    def white(self) -> float:
        """White level [grey values]."""
        return 255.0 if self.image.dtype == np.uint8 else 65535.0

    def plane(self) -> NDArray[np.generic]:
        """The brightness looked at, (h, w)."""
        if self.image.ndim == 2:
            return self.image
        if self.channel == "luma":
            return ((self.image.astype(np.int64) @ LUMA + 500) // 1000).astype(self.image.dtype)
        return self.image[:, :, self.band]


def prepare(image: NDArray[np.generic], channel: str) -> Picture:
    """`image` (h, w) or (h, w, 3), uint8 or uint16, seen in `channel`: "red", "green", "blue" or "luma"."""
    if channel not in CHANNELS:
        raise UsageError(f'Channel "{channel}" is not known; choose one of {", ".join(CHANNELS)}.')
    bands = image.shape[2] if image.ndim == 3 else 1
    if image.dtype not in (np.uint8, np.uint16) or image.ndim not in (2, 3) or (image.ndim == 3 and bands != 3):
        raise ImageError(f"An image must be uint8 or uint16, grey or with 3 bands, got {image.dtype} {image.shape}.")
    if min(image.shape[:2]) < SMALLEST:
        raise ImageError(
            f"An image must be at least {SMALLEST} x {SMALLEST} px, got {image.shape[1]} x {image.shape[0]} px."
        )
    return Picture(np.ascontiguousarray(image), channel)


def inside_of(plane: NDArray[np.generic], rays: Rays) -> NDArray[np.bool_]:
    """Which samples (n, samples) lie within the outermost pixel centres of `plane` (h, w)."""
    (column, row), (height, width) = rays.fixed(), plane.shape
    return (column >= 0) & (row >= 0) & (column <= (width - 1) * ONE) & (row <= (height - 1) * ONE)


def nearest_pixels(plane: NDArray[np.generic], rays: Rays, inside: NDArray[np.bool_]) -> Array:
    """Brightness (n, samples) of the nearest pixel, NaN outside."""
    (column, row), (height, width) = rays.fixed(), plane.shape
    c, r = ((a + ONE // 2) // ONE for a in (column, row))
    return np.where(inside, plane[np.clip(r, 0, height - 1), np.clip(c, 0, width - 1)].astype(np.float64), np.nan)


def bilinear(plane: NDArray[np.generic], rays: Rays, inside: NDArray[np.bool_]) -> Array:
    """Brightness (n, samples) interpolated between the four nearest pixels, NaN outside.

    In whole numbers, exact for places rounded down to 1 / `PART` px: both kernels see the same brightness.
    """
    (column, row), (height, width) = rays.fixed(), plane.shape
    column, row = np.where(inside, column, 0), np.where(inside, row, 0)
    left, top = np.minimum(column // ONE, width - 2), np.minimum(row // ONE, height - 2)
    x, y = (column - left * ONE) // PART, (row - top * ONE) // PART
    values = [plane[top + j, left + i].astype(np.int64) for j in (0, 1) for i in (0, 1)]
    upper, lower = values[0] * PART + x * (values[1] - values[0]), values[2] * PART + x * (values[3] - values[2])
    return np.where(inside, (upper * PART + y * (lower - upper)) / ONE, np.nan)

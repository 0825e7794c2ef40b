"""Samples of many rays about the places they are looked at from, as `native/src/stripe/windows.rs`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import ScanSettings
from calibore.stripe._picture import Picture, bilinear, inside_of
from calibore.stripe._rays import Rays

Array = NDArray[np.float64]
PHASES = 8
"""Rays are looked at from places on this part of a pixel, so that many of them weight their samples alike."""


@dataclass(frozen=True)
class Windows:
    """Samples of n rays: brightness `value` (n, m), NaN outside the picture, at `distance` (n, m) [px]
    from where each ray is looked at from, `apart` [px] from each other; the `width` (n,) [px] of the line there.
    """

    value: Array
    distance: Array
    apart: float
    width: Array

    def few(self, every: int) -> "Windows":
        """One ray in `every`."""
        return Windows(self.value[::every], self.distance[::every], self.apart, self.width[::every])


def standing(start: Array) -> Array:
    """`start` (n,) moved to the nearest places where rays may be looked at from."""
    return np.floor(start * PHASES + 0.5) / PHASES


def windows_about(picture: Picture, rays: Rays, start: Array, width: Array, settings: ScanSettings) -> Windows:
    """About `start` (n,) [px along the rays], NaN for rays without; the line is `width` (n,) [px] there."""
    known, plane, group = np.isfinite(start), picture.plane(), settings.group
    start = np.where(known, start, 0.0)
    middle = np.floor(start + 0.5).astype(np.intp)
    half = (settings.half_fit // group) * group + group // 2
    offset = np.arange(-half, half + group % 2)
    at = middle[:, None] + offset
    inside = known[:, None] & (at >= 0) & (at < rays.samples)
    every = bilinear(plane, rays, inside_of(plane, rays))
    value = np.where(inside, np.take_along_axis(every, np.clip(at, 0, rays.samples - 1), axis=1), np.nan)
    distance = offset.reshape(-1, group).mean(axis=1) + (middle - start)[:, None]
    return Windows(value.reshape(len(start), -1, group).mean(axis=2), distance, float(group), width)

"""Samples of many rays about the places they are looked at from, as `native/src/stripe/windows.rs`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import ScanSettings
from calibore.stripe._picture import Picture, bilinear, inside_of
from calibore.stripe._plateau import clipped_samples
from calibore.stripe._rays import Rays

Array = NDArray[np.float64]
PHASES = 8
"""Rays are looked at from places on this part of a pixel, so that many of them weight their samples alike."""


@dataclass(frozen=True)
class Windows:
    """Samples of n rays: brightness as it is `shown` (n, m), NaN outside the picture; its `value`, NaN where clipped,
    too; at `distance` (n, m) [px] from where each ray is looked at from, `apart` [px] from each other, from the `first`
    sample (n,) of the ray on; how far from there the farthest `clipped` sample is (n,) [px], -1 where none is; the
    `width` (n,) [px] of the line there.
    """

    shown: Array
    value: Array
    distance: Array
    apart: float
    first: NDArray[np.intp]
    clipped: Array
    width: Array

    def few(self, every: int) -> "Windows":
        """One ray in `every`."""
        shown, value, distance = self.shown[::every], self.value[::every], self.distance[::every]
        first, clipped, width = self.first[::every], self.clipped[::every], self.width[::every]
        return Windows(shown, value, distance, self.apart, first, clipped, width)


def standing(start: Array) -> Array:
    """`start` (n,) moved to the nearest places where rays may be looked at from."""
    return np.floor(start * PHASES + 0.5) / PHASES


def windows_about(
    picture: Picture,
    rays: Rays,
    start: Array,
    width: Array,
    settings: ScanSettings,
    bright: NDArray[np.bool_] | None,
) -> Windows:
    """About `start` (n,) [px along the rays], NaN for rays without; the line is `width` (n,) [px] there; `bright` rays
    (n,) may have clipped samples.
    """
    known, plane, group = np.isfinite(start), picture.plane(), settings.group
    start = np.where(known, start, 0.0)
    middle = np.floor(start + 0.5).astype(np.intp)
    half = (settings.half_fit // group) * group + group // 2
    offset = np.arange(-half, half + group % 2)
    at = middle[:, None] + offset
    inside = known[:, None] & (at >= 0) & (at < rays.samples)
    every = bilinear(plane, rays, inside_of(plane, rays))
    shown = np.where(inside, np.take_along_axis(every, np.clip(at, 0, rays.samples - 1), axis=1), np.nan)
    distance = offset.reshape(-1, group).mean(axis=1) + (middle - start)[:, None]
    shown, reach = shown.reshape(len(start), -1, group).mean(axis=2), np.full(start.size, -1.0)
    value = shown
    if bright is not None:
        white = np.take_along_axis(clipped_samples(picture, rays), np.clip(at, 0, rays.samples - 1), axis=1)
        white &= inside & bright[:, None]
        white = white.reshape(len(start), -1, group).any(axis=2)
        value = np.where(white, np.nan, shown)
        reach = np.max(np.where(white, np.abs(distance), -1.0), axis=1)
    return Windows(shown, value, distance, float(group), at[:, 0], reach, width)

"""Candidates along rays, as `native/src/stripe/{sampling,walk,peak,describe,scan}.rs`: specification and fallback.

Both sample the picture bilinearly along each ray, find where the slope fitted to `window` samples changes from rising
to falling, keep the peaks that stand out, and refine them.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import MOST_PEAKS, SATURATED_FROM, Peaks, ScanSettings
from calibore.stripe._picture import bilinear, inside_of, nearest_pixels
from calibore.stripe._rays import Rays
from calibore.stripe._refine import Standing, refine

Array = NDArray[np.float64]
FULL_WIDTH = 2.354820045
"""Full width at half height of a Gaussian over its sigma."""
GATE_STRIDE = 2
"""The gate looks at every second sample: of the three that can make a peak lit, one is among them."""
SATURATED_SAMPLES = 2
"""A peak with this many saturated samples is saturated."""


def scan(
    plane: NDArray[np.generic], rays: Rays, settings: ScanSettings, *, spans: NDArray[np.int64] | None = None
) -> Peaks:
    """Candidates on every ray of `plane` (h, w); peaks are looked for within `spans` (n, 2), first and end sample."""
    inside = inside_of(plane, rays)
    samples = bilinear(plane, rays, inside)
    sample = np.arange(rays.samples)
    bright = (nearest_pixels(plane, rays, inside) >= settings.gate) & (sample % GATE_STRIDE == 0)
    if spans is not None:
        bright &= (sample >= spans[:, :1]) & (sample < spans[:, 1:])
    ray, position, fraction = _crossings(samples, bright, settings)
    return _highest_first(_describe(samples, ray, position, fraction, settings), ray, rays.count)


def _crossings(
    samples: Array, bright: NDArray[np.bool_], settings: ScanSettings
) -> tuple[NDArray[np.intp], Array, Array]:
    """(ray, position, its fraction between two windows) where it is `bright` and the slope turns to falling."""
    if samples.shape[1] <= settings.window:
        return np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0)
    lever = np.arange(settings.window) - (settings.window - 1) / 2
    windows = np.lib.stride_tricks.sliding_window_view(samples, settings.window, axis=1)
    slope = windows @ lever
    turns = (slope[:, :-1] > 0) & (slope[:, 1:] <= 0)
    ray, first = np.nonzero(turns)
    before, after = slope[ray, first], slope[ray, first + 1]
    fraction = before / (before - after)
    position = first + (settings.window - 1) / 2 + fraction
    middle = (position + 0.5).astype(np.intp)
    last = samples.shape[1] - 1
    lit = bright[ray, middle] | bright[ray, np.maximum(middle - 1, 0)] | bright[ray, np.minimum(middle + 1, last)]
    return ray[lit], position[lit], fraction[lit]


def _describe(
    samples: Array, ray: NDArray[np.intp], position: Array, fraction: Array, settings: ScanSettings
) -> tuple[NDArray[np.bool_], Array]:
    """Which crossings are peaks, and their (position, height, background, width, u, saturated) as rows."""
    keep = np.zeros(ray.size, dtype=bool)
    rows = np.full((6, ray.size), np.nan)
    for index in range(ray.size):
        peak = described(samples[ray[index]], float(position[index]), float(fraction[index]), settings)
        if peak is not None:
            keep[index], rows[:, index] = True, peak
    return keep, rows


def described(y: Array, position: float, fraction: float, settings: ScanSettings) -> tuple[float, ...] | None:
    """One candidate refined, or None where it does not stand out; `fraction` places it between its two windows."""
    middle, whole = int(position + 0.5), int(position)
    low, high = max(middle - settings.reach, 0), min(middle + settings.reach, y.size - 1)
    left, right = np.nanmin(y[low : middle + 1]), np.nanmin(y[middle : high + 1])
    background = max(left, right)
    top = y[whole] + (y[whole + 1] - y[whole]) * (position - whole)
    height = top - background
    if not height >= settings.prominence or top < settings.threshold:
        return None
    half = background + 0.5 * height
    rise, fall = _half_height(y, middle, half, low), _half_height(y, middle, half, high)
    standing = Standing(position, fraction, height, 0.5 * (left + right), rise, fall)
    refined = refine(y, standing, settings)
    if refined is None:
        return None
    saturated = np.sum(y[low : high + 1] >= SATURATED_FROM * settings.white) >= SATURATED_SAMPLES
    return refined[0], height, background, (fall - rise) / FULL_WIDTH, refined[1], float(saturated)


def _half_height(y: Array, middle: int, level: float, end: int) -> float:
    """Where the line falls to `level` on the way from `middle` to `end`; `end` itself where it does not."""
    step = 1 if end > middle else -1
    for k in range(middle, end, step):
        if y[k + step] < level:
            return k + step * max(0.0, (y[k] - level) / (y[k] - y[k + step])) if y[k] >= level else float(k)
        if not np.isfinite(y[k + step]):
            return float(k)
    return float(end)


def _highest_first(columns: tuple[NDArray[np.bool_], Array], ray: NDArray[np.intp], count: int) -> Peaks:
    """Candidates sorted into (count, MOST_PEAKS) tables, highest first, ties in order along the ray."""
    keep, rows = columns
    ray, rows = ray[keep], rows[:, keep]
    order = np.lexsort((np.arange(ray.size), -rows[1], ray))
    ray, rows = ray[order], rows[:, order]
    rank = np.arange(ray.size) - np.searchsorted(ray, ray)
    table = np.full((6, count, MOST_PEAKS), np.nan)
    chosen = rank < MOST_PEAKS
    table[:, ray[chosen], rank[chosen]] = rows[:, chosen]
    return Peaks(table[0], table[1], table[2], table[3], table[4], table[5] > 0)

"""Speckle across the line, learnt from the line itself, as `native/src/stripe/across.rs`."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._neighbours import Standpoint
from calibore.stripe._noise import LEAST_CONTRAST, LONGEST_GRAIN, MOST_CONTRAST, NoiseModel
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]
CORE = 1.5
"""Line widths on each side of the middle in which speckle is learnt."""
BRIGHTEST = 4.0
"""Samples brighter than so many times the line are glare, not speckle, and count as this."""
FEWEST = 50
"""Pairs of samples at the same two distances from the middle that are needed."""
SHORTEST_GRAIN = 0.5
"""px."""


def speckle_across(
    windows: Windows, stand: Standpoint, base: Array, noise: NoiseModel, *, every: int = 1, flank: Array | None = None
) -> NoiseModel:
    """`noise` with contrast and grain from samples one and two apart in `windows` about `stand`, which share no noise
    of the sensor, on one ray in `every`; `base` (n,) is the background of every ray's peak. A contrast above that of
    `noise`, learnt along the line, is that of a line which strays from where its neighbours say, and is not taken.
    """
    apart, middle = windows.apart, windows.value.shape[1] // 2
    few = slice(None, None, every)
    calm = stand.calm[few]
    if not calm.any():
        return noise
    hidden = 0.0 if flank is None else max(float(np.median(flank[few][calm])), 0.0)
    core = int(np.clip(np.floor((CORE * noise.width + hidden) / apart + 0.5), 1, middle))
    columns = slice(middle - core, middle + core + 1)
    bell = np.exp(-(windows.distance[few] ** 2) / (2 * windows.width[few, None] ** 2))
    line, background = stand.height[few, None] * bell, float(np.median(base[few][calm]))
    share = ((windows.value[few] - background) / np.where(line > 0, line, np.nan))[calm, columns]
    share = np.minimum(share, BRIGHTEST)
    near, far = _relative_covariance(share, 1), _relative_covariance(share, 2)
    if np.isnan(near + far):
        return noise
    grain = _grain(near, far, apart)
    contrast = min(near * np.exp(apart**2 / (4 * grain**2)), noise.contrast)
    return replace(noise, contrast=float(np.clip(contrast, LEAST_CONTRAST, MOST_CONTRAST)), grain=grain)


def _grain(near: float, far: float, apart: float) -> float:
    """Grain [px] of a speckle correlation exp(-d^2 / 4 grain^2) from its values at d = `apart` and twice that."""
    if not 0 < far < near:
        return LONGEST_GRAIN if far >= near > 0 else SHORTEST_GRAIN
    return float(np.clip(apart * np.sqrt(0.75 / np.log(near / far)), SHORTEST_GRAIN, LONGEST_GRAIN))


def _relative_covariance(share: Array, lag: int) -> float:
    """Of columns of `share` (n, m) that are `lag` apart, over their means: mean by number of pairs; NaN of none."""
    total, pairs = 0.0, 0
    for one, other in zip(share.T[:-lag], share.T[lag:], strict=True):
        both = np.isfinite(one) & np.isfinite(other)
        count = int(both.sum())
        if count >= FEWEST:
            a, b = one[both], other[both]
            total += count * (np.mean(a * b) / (np.mean(a) * np.mean(b)) - 1)
            pairs += count
    return total / pairs if pairs else float("nan")

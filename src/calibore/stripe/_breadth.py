"""Width of the line, learnt from its mean profile, as `native/src/stripe/breadth.rs`.

Speckle breaks a line into peaks that are narrower than the line. Over many rays it averages out.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._neighbours import Standpoint
from calibore.stripe._noise import NoiseModel
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]
STEPS = 3
LONGEST, MOST = 0.3, 1.6
"""The width changes by this part at most in a step, and by this factor at most in all."""
BRIGHTEST = 4.0
"""Samples brighter than so many times the line are glare and count as this."""
FEWEST = 24
"""Rays that are needed."""


def breadth(windows: Windows, stand: Standpoint, noise: NoiseModel, *, every: int) -> NoiseModel:
    """`noise` with the width of a Gaussian fitted to the samples of one calm ray in `every`, over the line's height."""
    counted = (stand.calm & (stand.height > 0))[::every]
    if np.count_nonzero(counted) < FEWEST:
        return noise
    share = np.minimum(windows.value[::every][counted] / stand.height[::every][counted, None], BRIGHTEST)
    distance, known = windows.distance[::every][counted], np.isfinite(share)
    width = noise.width
    for _ in range(STEPS):
        square = distance[known] ** 2 / width**2
        bell = np.exp(-square / 2)
        design = np.stack([bell, bell * square / width, np.ones_like(bell)])
        normal = design @ design.T
        if not np.linalg.det(normal) > 0:
            return noise
        size, widening, _ = np.linalg.solve(normal, design @ share[known])
        step = widening / size if size else np.nan
        if not np.isfinite(step):
            return noise
        limit = LONGEST * width
        width = float(np.clip(width + np.clip(step, -limit, limit), noise.width / MOST, noise.width * MOST))
    return replace(noise, width=width)

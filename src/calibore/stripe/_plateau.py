"""Lines brighter than the picture can show, as `native/src/stripe/plateau.rs`: which samples are clipped, and where a
plateau has its middle.

A clipped sample says no more than that the line is bright there, and nearly all of what it knows about the place its
neighbours know as well: it is left out. On a plateau the slope is zero anywhere, so it is placed between its flanks.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import SATURATED_FROM, ScanSettings
from calibore.stripe._neighbours import reach_of
from calibore.stripe._picture import Picture, bilinear, inside_of
from calibore.stripe._rays import Rays

Array = NDArray[np.float64]
FEW = 0.05
"""Of all rays ..."""
NEARBY, MOST = 24.0, 0.5
"""... and of those so many line widths on each side."""
BRIGHT = 0.7
"""Peaks above this part of white may have clipped pixels beside them."""
WIDEST_PLATEAU = 48
"""Samples on each side within which a plateau has its flanks: a wider one is no line."""
HALF = 0.5
"""Of the height that is left: where flanks are looked for."""


def bright_rays(
    height: Array, base: Array, saturated: NDArray[np.bool_], settings: ScanSettings, rays: Rays
) -> NDArray[np.bool_] | None:
    """Rays (n,) whose peaks, `height` above `base` (n,), may have clipped samples; None where few are clipped, and
    nowhere most: a clipped grain of speckle here and there still says that it is bright.
    """
    top = height + base
    clipped = saturated | (top >= settings.saturated_from)
    if not clipped.any():
        return None
    reach = reach_of(clipped.size, NEARBY * settings.noise.width, rays.spacing)
    padded = np.pad(clipped, reach, mode="wrap") if rays.closed else np.pad(clipped, reach)
    total = np.concatenate([[0], np.cumsum(padded)])
    nearby = int((total[2 * reach + 1 :] - total[: -2 * reach - 1]).max())
    if clipped.sum() <= FEW * clipped.size and nearby <= MOST * (2 * reach + 1):
        return None
    return saturated | (top >= BRIGHT * settings.white)


def clipped_samples(picture: Picture, rays: Rays) -> NDArray[np.bool_]:
    """Which samples (n, m) a clipped pixel has part in."""
    plane = picture.plane()
    white = (plane.astype(np.float64) >= SATURATED_FROM * picture.white).astype(np.uint8)
    return bilinear(white, rays, inside_of(plane, rays)) > 0


def plateau_middles(samples: Array, position: Array, height: Array, base: Array, saturated: NDArray[np.bool_]) -> Array:
    """`position` (n,) [px] of peaks on rays of `samples` (n, m), those `saturated` in the middle between both places
    where the line falls to half of its `height` above `base` (n,); unchanged where it does not.
    """
    place = position.copy()
    for ray in np.flatnonzero(saturated & np.isfinite(position)):
        middle, level = int(np.floor(position[ray] + 0.5)), base[ray] + HALF * height[ray]
        edges = [_edge(samples[ray], middle, level, side) for side in (-1, 1)]
        if edges[0] is not None and edges[1] is not None:
            place[ray] = 0.5 * (edges[0] + edges[1])
    return place


def _edge(y: Array, middle: int, level: float, side: int) -> float | None:
    """Where `y` (m,) falls below `level` on one `side` of the sample `middle`; None where it does not nearby."""
    for k in range(middle, middle + side * WIDEST_PLATEAU, side):
        if not (0 <= k < y.size and 0 <= k + side < y.size and y[k] >= level):
            return None
        if y[k + side] < level:
            return k + side * float((y[k] - level) / (y[k] - y[k + side]))
    return None

"""Width of the line, learnt from its mean profile, as `native/src/stripe/breadth.rs`.

Speckle breaks a line into peaks that are narrower than the line. Over many rays it averages out. The light of a cone
meets one side of a wall at another angle than the other, and a wall beside the focus is seen blurred: then the width
differs along the line.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._neighbours import Standpoint
from calibore.stripe._pieces import FEWEST as FEWEST_OF_PIECE
from calibore.stripe._pieces import PIECES, along, bridged, pieces, smoothed
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]
STEPS = 3
LONGEST, MOST = 0.3, 1.6
"""The width changes by this part at most in a step, and by this factor at most in all."""
BRIGHTEST = 4.0
"""Samples brighter than so many times the line are glare and count as this."""
FEWEST = 24
"""Rays that are needed."""
BEYOND = 3.0
"""Widths differ along the line if their variance is so many times that of neighbouring pieces."""
LEVEL = 1.1
"""Factor between the widths that are told apart."""


def breadth(windows: Windows, stand: Standpoint, width: float, *, every: int) -> float:
    """Width [px] of a Gaussian fitted to the samples of one calm ray in `every`, over the line's height; the `width`
    known before where these are too few.
    """
    counted = _counted(stand, every)
    enough = np.count_nonzero(counted) >= FEWEST
    return _fitted(*_profile(windows, stand, counted), width, STEPS) if enough else width


def breadths(windows: Windows, stand: Standpoint, width: float, *, every: int, closed: bool) -> tuple[float, Array]:
    """The same, and that (n,) of the line at every ray, which is the same unless it differs along the line beyond doubt
    [px].
    """
    every_ray, counted = np.ones(stand.calm.size), _counted(stand, every)
    if np.count_nonzero(counted) < FEWEST:
        return width, width * every_ray
    share, distance = _profile(windows, stand, counted)
    width = _fitted(share, distance, width, STEPS)
    whole = np.isfinite(share).all(axis=1)
    piece = pieces(stand.calm.size)[counted][whole]
    local = _local(share[whole], distance[whole], piece, width, closed)
    if local is None:
        return width, width * every_ray
    level = np.floor(np.log(along(local / width, stand.calm.size, closed=closed)) / np.log(LEVEL) + 0.5)
    return width, width * LEVEL**level


def _counted(stand: Standpoint, every: int) -> NDArray[np.bool_]:
    return stand.calm & (stand.height > 0) & (np.arange(stand.calm.size) % every == 0)


def _profile(windows: Windows, stand: Standpoint, counted: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Samples over the height of the line, and where they lie [px], of the rays `counted`."""
    share = np.minimum(windows.value[counted] / stand.height[counted, None], BRIGHTEST)
    return share, windows.distance[counted]


def _local(share: Array, distance: Array, piece: NDArray[np.intp], width: float, closed: bool) -> Array | None:
    """Width (PIECES,) of each `piece` (n,) of the line, None where it does not differ."""
    parts = [(share[piece == k], distance[piece == k]) for k in range(PIECES)]

    def fitted(steps: int) -> Array:
        some = [_fitted(*part, width, steps) if len(part[0]) >= FEWEST_OF_PIECE else np.nan for part in parts]
        return bridged(np.array(some), closed=closed)

    first = fitted(1)
    beside = np.diff(first, append=first[:1] if closed else np.zeros(0))
    if not np.mean((first - np.mean(first)) ** 2) > BEYOND * np.mean(beside**2) / 2:
        return None
    return smoothed(fitted(STEPS), closed=closed)


def _fitted(share: Array, distance: Array, first: float, steps: int) -> float:
    """Width of the profile of samples `share` (n, m) at `distance` (n, m) after so many steps from the `first`, which
    stays where they do not tell.
    """
    known, width = np.isfinite(share), first
    for _ in range(steps):
        square = distance[known] ** 2 / width**2
        bell = np.exp(-square / 2)
        design = np.stack([bell, bell * square / width, np.ones_like(bell)])
        normal = design @ design.T
        if not np.linalg.det(normal) > 0:
            return first
        size, widening, _ = np.linalg.solve(normal, design @ share[known])
        step = widening / size if size else np.nan
        if not np.isfinite(step):
            return first
        limit = LONGEST * width
        width = float(np.clip(width + np.clip(step, -limit, limit), first / MOST, first * MOST))
    return width

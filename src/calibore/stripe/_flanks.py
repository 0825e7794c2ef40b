"""What the flanks tell of a line whose top is clipped: its width, and how high it would be; as
`native/src/stripe/flanks.rs`.

Where the brightest samples are missing because they are bright, the rest is darker than the line is. So nothing is
learnt from samples as near to the middle as those that are often clipped on the rays nearby; further out, a clipped one
counts as what it shows.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._breadth import breadth, breadths
from calibore.stripe._neighbours import Standpoint, reach_of
from calibore.stripe._noise import MOST_CONTRAST, NoiseModel
from calibore.stripe._rays import Rays
from calibore.stripe._smear import unsmeared
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]
OFTEN = 0.2
"""On more than this share of the rays nearby."""
ROUNDS, SETTLED, UNSMEARED = 6, 1e-3, 2
"""Width and height depend on each other: so many rounds at most, until the width changes by no more than this part;
what interpolating does depends on both, and matters last.
"""
MOST = 2.5
"""The width is found within this factor."""
HIGHEST = 64.0
"""A line may be so many times higher than what is left of it."""
FEWEST = 24
"""Rays whose top is not clipped that tell how much higher a peak is than the line."""
SEEN = 0.5
"""Of the rays: where more are clipped, nobody has learnt speckle along the line."""


def flanks_of(windows: Windows, rays: Rays, *, within: float) -> Array:
    """How far [px] from the middle samples are often clipped on the rays `within` [px] of each (n,), and half a sample
    further, for lines lie anywhere between samples; -1 where none is.
    """
    reach = reach_of(windows.clipped.size, within, rays.spacing)
    padded = np.pad(windows.clipped, reach, mode="wrap") if rays.closed else np.pad(windows.clipped, reach, mode="edge")
    rank = int((1 - OFTEN) * 2 * reach)
    often = np.sort(np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1), axis=1)[:, rank]
    return np.where(often >= 0, often + 0.5 * windows.apart, -1.0)


def beyond(windows: Windows, flank: Array) -> Windows:
    """`windows` with clipped samples, but without those up to `flank` (n,) [px] from the middle."""
    return replace(windows, value=np.where(np.abs(windows.distance) > flank[:, None], windows.shown, np.nan))


def learn_flanks(
    windows: Windows,
    stand: Standpoint,
    flank: Array,
    noise: NoiseModel,
    rays: Rays,
    *,
    within: float,
    every: int,
) -> tuple[Windows, Array, NoiseModel]:
    """`windows` without what is within the `flank` (n,), with the width of the line at every ray; its height (n,) and
    `noise` with its width learnt from them. Where its top is hidden anywhere the width is the same everywhere.
    """
    seen, width, hidden = beyond(windows, flank), noise.width, flank >= 0
    if not hidden.any():
        width, widths = breadths(seen, stand, noise.width, every=every, closed=rays.closed)
        return replace(seen, width=widths), stand.height, replace(noise, width=width)
    height, settled = heights(seen, stand, flank, width, rays, within=within), False
    for number in range(ROUNDS + UNSMEARED * rays.closed):
        if number >= ROUNDS:
            seen = beyond(unsmeared(windows, rays, height, noise.width, hidden), flank)
        elif settled:
            continue
        learnt = breadth(seen, replace(stand, height=height), noise.width, every=every)
        learnt = float(np.clip(learnt, width / MOST, width * MOST))
        settled = abs(learnt - noise.width) <= SETTLED * noise.width
        noise = replace(noise, width=learnt)
        height = heights(seen, stand, flank, noise.width, rays, within=within)
    if np.count_nonzero(hidden & stand.calm) > SEEN * np.count_nonzero(stand.calm):
        noise = replace(noise, contrast=MOST_CONTRAST)
    return replace(seen, width=np.full(hidden.size, noise.width)), height, noise


def heights(windows: Windows, stand: Standpoint, flank: Array, width: float, rays: Rays, *, within: float) -> Array:
    """Height (n,) of the line where its top is clipped, elsewhere that of `stand`: by least squares of a Gaussian of
    `width` [px] on the samples of the rays `within` [px] of each, its height and the background free.
    """
    known = np.isfinite(windows.value) & stand.calm[:, None]
    bell = np.where(known, np.exp(-(windows.distance**2) / (2 * width**2)), 0.0)
    value = np.where(known, windows.value, 0.0)
    sums = np.stack([known.sum(axis=1), *(np.sum(a, axis=1) for a in (bell, bell**2, value, bell * value))])
    reach = reach_of(len(stand.height), within, rays.spacing)
    padded = (
        np.pad(sums, ((0, 0), (reach, reach)), mode="wrap") if rays.closed else np.pad(sums, ((0, 0), (reach, reach)))
    )
    count, one, two, total, leaning = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=1).sum(
        axis=2
    )
    determinant = count * two - one**2
    height = np.divide(
        count * leaning - one * total, determinant, out=np.full(len(count), np.nan), where=determinant > 0
    )
    seen = stand.calm & (flank < 0) & (height > 0)
    if np.count_nonzero(seen) >= FEWEST:
        height = height * np.median(stand.height[seen] / height[seen])
    hidden = (flank >= 0) & (stand.height > 0) & np.isfinite(height)
    return np.where(hidden, np.clip(height, stand.height, HIGHEST * stand.height), stand.height)

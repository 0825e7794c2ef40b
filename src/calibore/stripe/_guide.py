"""Guidance: where on its ray the final scan looks, from what every fifth ray has shown.

The coarse scan sees the whole of every `COARSE`-th ray, or of more of them across a line in a small picture. A line on
the rays between can only be where the rule of continuity (`_chain`) lets it go from there. So the final scan looks for
peaks within that distance of everything the coarse scan found on the two coarse rays on each side, line or not; and on
the whole ray where it found nothing there.

Nothing that could be the line, or its rival, is missed: it would have to form a chain of `SHORTEST` = 10 rays, and 10
rays in a row contain at least two coarse ones. (A chain full of gaps that has no peak on any coarse ray is not seen; a
full scan would not have centred on it either.) A speck on one to four rays between two coarse ones may go unseen: it
cannot be the line, and it does not change its place; a ray it lies on may then be OK where a full scan had called it
RESOLVED.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._chain import SLACK, STEEPEST

Array = NDArray[np.float64]
COARSE = 5
"""Every fifth ray is enough to find the centre and to learn the noise."""
LEAST_MARGIN = 12.0
"""Pixels looked at on each side of what the coarse scan found, at least; and how far its centre may be off."""


def guided_spans(position: Array, *, samples: int, spacing: float, shift: float) -> NDArray[np.int64]:
    """First and end sample (m, 2) to look for peaks on each coarse ray and those after it, until the next one.

    From coarse candidates at `position` (m, k) [px], NaN = none, on rays of `samples`, `spacing` [px] apart, whose
    centre lay `shift` [px] off the one to be looked from; after a longer move than `LEAST_MARGIN` everything is new.
    """
    margin = max(LEAST_MARGIN, SLACK + STEEPEST * spacing) + shift
    low = np.min(np.where(np.isfinite(position), position, np.inf), axis=1)
    high = np.max(np.where(np.isfinite(position), position, -np.inf), axis=1)
    around = (np.arange(len(position))[:, None] + np.arange(-1, 3)) % len(position)
    low, high = low[around].min(axis=1) - margin, high[around].max(axis=1) + margin
    new = (low > high) | (shift > LEAST_MARGIN)
    span = np.stack([np.where(new, 0, low), np.where(new, samples, high + 1)], axis=1)
    return np.clip(np.floor(span).astype(np.int64), 0, samples)

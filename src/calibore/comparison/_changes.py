"""What has changed between two epochs: where a difference is more than chance, how large, and how fast."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._chance import thresholds
from calibore.comparison._difference import Difference
from calibore.comparison._region import Region, region_of
from calibore.comparison._smoothing import Smoother, windows_of
from calibore.errors import InputError

Array = NDArray[np.float64]
GROWN = 0.75
"""Of the limit: a change that is certain reaches as far as it is likely; its middle is not where noise helped."""
FALSE_ALARM = 0.05
"""Probability that an unchanged pipe shows any region at all."""
DETECTED = 1.64
"""Standard uncertainties beyond the threshold at which a change is found in 95 of 100 cases."""


@dataclass(frozen=True, eq=False)
class Changes:
    """`significance` (n, m): the greatest mean over any window around a point, in its standard uncertainties, signed;
    means over windows that are fewer count as much more as chance makes them smaller. `threshold` that an unchanged
    pipe exceeds anywhere with the probability `false_alarm`; `regions`, largest first.

    `level_of_detection` (n, m) [m]: the least change of the best window around a point that is found with 95 %
    probability.
    """

    difference: Difference
    significance: Array
    threshold: float
    false_alarm: float
    level_of_detection: Array
    regions: tuple[Region, ...]


def changes(difference: Difference, *, false_alarm: float = FALSE_ALARM, seed: int = 0) -> Changes:
    """Regions of significant change in `difference`, after minus before; the same `seed` gives the same threshold."""
    if not 0 < false_alarm < 1:
        raise InputError(f"A probability of false alarm lies between 0 and 1, got {false_alarm:g}.")
    smoother, windows = Smoother.of(difference), windows_of(difference)
    rng = np.random.default_rng(seed)
    limits = thresholds(difference, smoother, windows, false_alarm=false_alarm, rng=rng)
    limit = max(limits.values())
    strongest = np.zeros(difference.value.shape)
    detectable = np.full(difference.value.shape, np.inf)
    for window, own in limits.items():
        u = smoother.u(window)
        relative = np.nan_to_num(smoother.mean(difference.adjusted, window) / u) * limit / own
        strongest = np.where(np.abs(relative) > np.abs(strongest), relative, strongest)
        detectable = np.fmin(detectable, (own + DETECTED) * u)
    known = np.isfinite(difference.adjusted)
    # a gap within a region does not part it, but is no part of it
    masks = [cells & known for cells in _connected(strongest, limit)]
    regions = [region_of(difference, cells) for cells in masks if cells.any()]
    return Changes(
        difference,
        np.where(known, strongest, np.nan),
        limit,
        false_alarm,
        np.where(known & np.isfinite(detectable), detectable, np.nan),
        tuple(sorted(regions, key=lambda one: -abs(one.volume.value))),
    )


def _connected(strongest: Array, limit: float) -> list[NDArray[np.bool_]]:
    """Masks (n, m) of points that touch, of one sign, beyond `GROWN` of the limit, some of them beyond all of it; the
    clock goes round.
    """
    from scipy.ndimage import label

    masks = []
    for sign in (1, -1):
        labels = np.zeros(strongest.shape, dtype=np.int32)
        label(sign * strongest > GROWN * limit, structure=np.ones((3, 3)), output=labels)
        for row in range(len(labels)):
            for other in range(max(row - 1, 0), min(row + 2, len(labels))):
                left, right = labels[row, 0], labels[other, -1]
                if left and right and left != right:
                    labels[labels == right] = left
        masks += [labels == one for one in np.unique(labels[sign * np.nan_to_num(strongest) > limit])]
    return masks

"""The pixels on both sides of a curve, dealt out to bins along it: every pixel to one bin, so that bins do not share
noise.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Array, Whole
from calibore.targets._rings_curves import Curve

SAMPLING = 0.7
"""px between trial places across the curve: no pixel is passed over."""
FULL = 0.7
"""Of the pixels that a whole bin would hold, a bin must hold this fraction, and as much on its thinner side."""
CORE = 1.0
"""px to both sides of the curve that are counted on their own: a line hidden there is not measured."""

Usable = Callable[[Array, Array, Array], NDArray[np.bool_]]
"""Whether pixels at u, v (n,) [px], whose feet lie at an index (n,) of the curve, show the line and nothing else."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Pixels sorted by bin: their `value` (n,), distance `across` (n,) [px] from the curve, `index` (n,) of their foot;
    the first pixel `starts` (b,) of each bin and `middle` (b,), the index of its middle. `step` [px]: length of a bin.
    """

    value: Array
    across: Array
    index: Array
    starts: Whole
    middle: Array
    step: float

    @property
    def bins(self) -> Whole:
        """The bin (n,) of each pixel."""
        counts = np.diff(np.append(self.starts, self.value.size))
        return np.repeat(np.arange(self.starts.size), counts)


def strip_along(plane: Array, curve: Curve, half: Array, *, step: float, usable: Usable) -> Strip:
    """The pixels within `half` (m,) [px] of the places of `curve`, in bins about `step` [px] long; bins that are not
    full are left out.
    """
    count = max(1, round(curve.length / step))
    step = curve.length / count
    u, v = _pixels(plane.shape, curve, float(half.max()))
    places = np.stack([u, v], axis=1)
    index, across = curve.foot(places, curve.start(places))
    inside = np.abs(across) <= curve.at(half, index)
    if curve.closed:
        index = index % len(curve.arc)
    else:
        inside &= (index >= 0) & (index <= len(curve.arc) - 1)
    inside[inside] &= usable(u[inside], v[inside], index[inside])
    u, v, index, across = u[inside], v[inside], index[inside], across[inside]
    arc = np.interp(index, np.arange(len(curve.arc) + 1), np.append(curve.arc, curve.length))
    bins = np.minimum((arc / step).astype(np.intp), count - 1)
    middles = np.interp((np.arange(count) + 0.5) * step, np.append(curve.arc, curve.length), np.arange(len(half) + 1))
    full = _full(bins, across, curve.at(half, middles), step)
    kept = full[bins]
    order = np.argsort(bins[kept], kind="stable")
    value = plane[v[kept], u[kept]].astype(float)[order]
    bins = bins[kept][order]
    starts = np.searchsorted(bins, np.flatnonzero(full))
    return Strip(value, across[kept][order], index[kept][order], starts, middles[full], step)


def _pixels(shape: tuple[int, ...], curve: Curve, reach: float) -> tuple[Whole, Whole]:
    """Columns and rows of all pixels within `reach` of the curve, and some more."""
    across = np.arange(-reach - 1, reach + 1 + SAMPLING, SAMPLING)
    places = curve.point[:, None] + across[:, None] * curve.normal[:, None]
    column, row = np.rint(places).astype(np.intp).reshape(-1, 2).T
    seen = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    row, column = np.divmod(np.unique(row[seen] * shape[1] + column[seen]), shape[1])
    return column, row


def _full(bins: Whole, across: Array, half: Array, step: float) -> NDArray[np.bool_]:
    """Which bins (b,) have all they need: pixels, on both sides, and on the line."""
    least = FULL * step
    near = np.minimum(CORE, half)
    left, right = (np.bincount(bins[side], minlength=half.size) for side in (across < 0, across >= 0))
    core = np.bincount(bins[np.abs(across) < near[bins]], minlength=half.size)
    return (half > CORE) & (left >= least * half) & (right >= least * half) & (core >= 2 * least * near - 1)

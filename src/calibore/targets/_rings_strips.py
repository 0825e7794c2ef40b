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

Usable = Callable[[Array, Array], NDArray[np.bool_]]
"""Whether pixels at u, v (n,) [px] show the line and nothing else."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Pixels sorted by bin: their `value` (n,) and distance `across` (n,) [px] from the curve; the first pixel `starts`
    (b,) of each bin and the index of the curve in its `middle` (b,).
    """

    value: Array
    across: Array
    starts: Whole
    middle: Array

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
    row, column, index, across = _beside(plane.shape, curve, half, usable)
    arc, tables = np.append(curve.arc, curve.length), np.arange(len(curve.arc) + 1.0)
    bins = np.minimum((np.interp(index, tables, arc) / step).astype(np.intp), count - 1)
    middles = np.interp((np.arange(count) + 0.5) * step, arc, tables)
    full = _full(bins, across, curve.at(half, middles), step)
    order = np.argsort(bins, kind="stable")
    order = order[full[bins[order]]]
    starts = np.searchsorted(bins[order], np.flatnonzero(full))
    return Strip(plane[row[order], column[order]].astype(float), across[order], starts, middles[full])


def _beside(shape: tuple[int, ...], curve: Curve, half: Array, usable: Usable) -> tuple[Whole, Whole, Array, Array]:
    """Row and column (n,) of the usable pixels within `half` of the curve, index of their feet, distance from it."""
    row, column = _pixels(shape, curve, float(half.max()))
    places = np.stack([column, row], axis=1).astype(float)
    index, across = curve.foot(places, curve.start(places))
    inside = np.abs(across) <= curve.at(half, index)
    if not curve.closed:
        inside &= (index >= 0) & (index <= len(curve.arc) - 1)
    inside[inside] &= usable(*places[inside].T)
    index = index % len(curve.arc) if curve.closed else index
    return row[inside], column[inside], index[inside], across[inside]


def _pixels(shape: tuple[int, ...], curve: Curve, reach: float) -> tuple[Whole, Whole]:
    """Rows and columns of all pixels within `reach` of the curve, and some more."""
    across = np.arange(-reach - 1, reach + 1 + SAMPLING, SAMPLING)
    places = curve.point[:, None] + across[:, None] * curve.normal[:, None]
    column, row = np.rint(places).astype(np.intp).reshape(-1, 2).T
    seen = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    row, column = np.divmod(np.unique(row[seen] * shape[1] + column[seen]), shape[1])
    return row, column


def _full(bins: Whole, across: Array, half: Array, step: float) -> NDArray[np.bool_]:
    """Which bins (b,) have all they need: pixels, on both sides, and on the line."""
    least = FULL * step
    near = np.minimum(CORE, half)
    left, right = (np.bincount(bins[side], minlength=half.size) for side in (across < 0, across >= 0))
    core = np.bincount(bins[np.abs(across) < near[bins]], minlength=half.size)
    return (half > CORE) & (left >= least * half) & (right >= least * half) & (core >= 2 * least * near - 1)

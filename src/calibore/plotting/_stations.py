"""Stations laid out along the pipe: order, the stretch each one stands for, gaps, and thinning for display."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.plotting._lengths import LengthUnit, axial_unit

MOST_COLUMNS = 900
"""More stations than this do not fit the pixels of a picture: blocks of stations are drawn, each by its extreme."""

GAP_FACTOR = 3.0
"""A step more than this many median steps long is a gap: nothing was measured there, and nothing is drawn."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Layout:
    """Where the stations lie on the axis of a picture.

    `order` (n,) sorts the given stations; `position`, `left`, `right` (n,) are in `unit`, sorted; `joined` (n - 1,)
    tells whether a station touches the next. Without usable axial positions the station numbers take their place
    (`unit` None).
    """

    order: NDArray[np.intp]
    position: Floats
    left: Floats
    right: Floats
    joined: NDArray[np.bool_]
    unit: LengthUnit | None

    @property
    def label(self) -> str:
        return "station number" if self.unit is None else f"axial position along the pipe [{self.unit.symbol}]"

    @property
    def limits(self) -> tuple[float, float]:
        """First and last edge; a single station gets room on both sides."""
        if len(self.position) > 1:
            return float(self.left[0]), float(self.right[-1])
        width = float(self.right[0] - self.left[0])
        return float(self.left[0]) - width, float(self.right[0]) + width

    def text(self, position: float) -> str:
        """`position` of this axis in words, such as "axial 1.20 m" or "station 7"."""
        return f"station {position:.0f}" if self.unit is None else f"axial {position:.4g} {self.unit.symbol}"


def lay_out(axial: Any, station: Any, *, unit: str, lone_width: float) -> Layout:
    """Stations at `axial` (n,) [m] with numbers `station` (n,); a lone station is drawn `lone_width` [m] wide."""
    axial, station = np.asarray(axial, float), np.asarray(station, float)
    usable = bool(np.all(np.isfinite(axial))) and (len(axial) == 1 or np.ptp(axial) > 0)
    scale = axial_unit(unit, float(np.ptp(axial))) if usable else None
    along = axial / scale.metres if scale else station
    order = np.argsort(along, kind="stable")
    position = along[order]
    left, right, joined = _edges(position, lone_width / scale.metres if scale else 1.0)
    return Layout(order, position, left, right, joined, scale)


def _edges(position: Floats, lone_width: float) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    steps = np.diff(position)
    typical = float(np.median(steps[steps > 0])) if np.any(steps > 0) else lone_width
    joined = steps <= GAP_FACTOR * typical
    half = np.where(joined, steps, typical) / 2
    first, last = (half[0] or typical / 2, half[-1] or typical / 2) if len(half) else (typical / 2, typical / 2)
    return position - np.append(first, half), position + np.append(half, last), joined


def block_starts(count: int, most: int = MOST_COLUMNS) -> NDArray[np.intp]:
    """Where blocks begin when `count` items are gathered into at most `most` blocks of nearly equal size."""
    blocks = min(count, most)
    return np.arange(blocks, dtype=np.intp) * count // blocks


def block_extremes(values: Floats, starts: NDArray[np.intp], *, axis: int = 0) -> Floats:
    """The value of largest magnitude in every block along `axis`, its sign kept; NaN only where all of a block is."""
    high = np.fmax.reduceat(values, starts, axis=axis)
    low = np.fmin.reduceat(values, starts, axis=axis)
    return np.where(np.abs(low) > np.abs(high), low, high)


def thinned(layout: Layout, most: int = MOST_COLUMNS) -> tuple[Layout, NDArray[np.intp]]:
    """`layout` gathered into at most `most` blocks, and where the blocks start (in sorted order).

    Stations at one and the same position (a rig that stood still) share a block.
    """
    moved = np.flatnonzero(np.diff(layout.position, prepend=-np.inf) > 0)
    starts = moved[block_starts(len(moved), most)]
    if len(starts) == len(layout.position):
        return layout, starts
    ends = np.append(starts[1:], len(layout.position)) - 1
    middle = (layout.position[starts] + layout.position[ends]) / 2
    joined = layout.joined[ends[:-1]]
    return Layout(layout.order[starts], middle, layout.left[starts], layout.right[ends], joined, layout.unit), starts


def thinning_note(count: int, columns: int) -> list[str]:
    """What to say about thinning: nothing, or that blocks are drawn by their extremes."""
    if columns == count:
        return []
    return [f"{count} stations thinned to {columns} columns for display; each column shows the extreme of its stations"]

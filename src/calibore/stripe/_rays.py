"""Where to look: straight rays of samples one pixel apart, each of which should cross the laser line once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rays:
    """`start` (n, 2) [px] as (column, row), unit `direction` (n, 2), `samples` per ray, one pixel apart.

    `closed` rays go round a ring, so the last is a neighbour of the first. `spacing` [px] is the distance of two
    neighbouring rays where they are expected to meet the line.
    """

    start: Array
    direction: Array
    samples: int
    closed: bool
    spacing: float

    def at(self, position: Array) -> tuple[Array, Array]:
        """Pixel coordinates (column, row) at `position` (n,) or (n, k) [px] along the rays."""
        extra = (slice(None),) + (None,) * (position.ndim - 1)
        column = self.start[:, 0][extra] + position * self.direction[:, 0][extra]
        return column, self.start[:, 1][extra] + position * self.direction[:, 1][extra]

    def near(self, position: Array, reach: int) -> "Rays":
        """The part of every ray within `reach` samples of `position` (n,) [px]; of its start where that is NaN."""
        first = np.floor(np.where(np.isfinite(position), position, 0.0)) - reach
        return Rays(self.start + first[:, None] * self.direction, self.direction, 2 * reach + 2, self.closed, self.spacing)

    def every(self, stride: int) -> "Rays":
        """Every `stride`-th ray."""
        return Rays(self.start[::stride], self.direction[::stride], self.samples, self.closed, self.spacing * stride)


def annulus(centre: tuple[float, float], *, inner: float, outer: float, count: int) -> Rays:
    """`count` radial rays from `inner` to `outer` [px] about `centre`: the unwrapped annulus (Swanbom 2007, 6.3.4.1).

    Azimuth runs from +column towards +row.
    """
    if not 0 <= inner < outer or count < 16:
        raise InputError(f"An annulus needs 0 <= inner < outer and 16 rays, got {inner} px, {outer} px, {count} rays.")
    azimuth = np.arange(count) * (2 * np.pi / count)
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    spacing = 2 * np.pi * 0.5 * (inner + outer) / count
    return Rays(np.asarray(centre) + inner * direction, direction, int(np.ceil(outer - inner)) + 1, True, spacing)


def columns(shape: tuple[int, ...], *, first: int = 0, last: int | None = None) -> Rays:
    """One ray down every pixel column from row 0: for a line that runs across the picture."""
    column = np.arange(first, shape[1] if last is None else last, dtype=np.float64)
    start = np.stack([column, np.zeros_like(column)], axis=1)
    return Rays(start, np.tile([0.0, 1.0], (column.size, 1)), shape[0], False, 1.0)

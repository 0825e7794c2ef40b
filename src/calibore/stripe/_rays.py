"""Where to look: straight rays of samples one pixel apart, each of which should cross the laser line once."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

ONE = 1 << 32
"""One pixel in 32.32 fixed point. Both kernels step along rays in it, so that they look at the same places exactly."""
FARTHEST = 2.0**20
"""Largest coordinate or radius [px]: far beyond any image, and small enough for fixed point."""
FEWEST_RAYS, MOST_RAYS = 16, 1 << 16
"""The most are a ray per pixel round a ring ten thousand pixels in radius."""


@dataclass(frozen=True)
class Rays:
    """`start` (n, 2) [px] as (column, row), unit `direction` (n, 2), `samples` per ray, one pixel apart.

    `closed` rays go round a ring, so the last is a neighbour of the first. `spacing` [px] is the distance of two
    neighbouring rays where they are expected to meet the line. Each ray stands for `stride` rays of a denser set.
    """

    start: Array
    direction: Array
    samples: int
    closed: bool
    spacing: float
    stride: int = 1

    @property
    def count(self) -> int:
        return len(self.start)

    def at(self, position: Array) -> tuple[Array, Array]:
        """Pixel coordinates (column, row) at `position` (n,) or (n, k) [px] along the rays."""
        extra = (slice(None),) + (None,) * (position.ndim - 1)
        column = self.start[:, 0][extra] + position * self.direction[:, 0][extra]
        return column, self.start[:, 1][extra] + position * self.direction[:, 1][extra]

    def fixed(self) -> tuple[Whole, Whole]:
        """Columns and rows (n, samples) of all samples in fixed point."""
        start, step = (np.floor(a * float(ONE)).astype(np.int64) for a in (self.start, self.direction))
        sample = np.arange(self.samples)
        return start[:, 0, None] + sample * step[:, 0, None], start[:, 1, None] + sample * step[:, 1, None]

    def every(self, stride: int) -> "Rays":
        """Every `stride`-th ray."""
        return replace(
            self,
            start=self.start[::stride],
            direction=self.direction[::stride],
            spacing=self.spacing * stride,
            stride=self.stride * stride,
        )


def annulus(centre: tuple[float, float], *, inner: float, outer: float, count: int) -> Rays:
    """`count` radial rays from `inner` to `outer` [px] about `centre`: the unwrapped annulus (Swanbom 2007, 6.3.4.1).

    Azimuth runs from +column towards +row.
    """
    direction = compass(count)
    spacing = 2 * np.pi * 0.5 * (inner + outer) / count
    return Rays(np.asarray(centre) + inner * direction, direction, int(np.ceil(outer - inner)) + 1, True, spacing)


def check_annulus(centre: tuple[float, float], inner: float, outer: float, count: int) -> None:
    """Raise InputError where no rays can be laid into the annulus."""
    if not all(abs(c) <= FARTHEST for c in centre):
        raise InputError(
            f"The centre to look about must lie within {FARTHEST:.0f} px of the image, got {centre[0]}, {centre[1]} px."
        )
    if not 0 <= inner < outer <= FARTHEST:
        raise InputError(
            f"The search region needs 0 <= inner < outer <= {FARTHEST:.0f} px, got inner {inner} px, outer {outer} px."
        )
    if not FEWEST_RAYS <= count <= MOST_RAYS:
        raise InputError(f"The number of rays must be {FEWEST_RAYS} to {MOST_RAYS}, got {count}.")


@lru_cache(maxsize=8)
def compass(count: int) -> Array:
    """Unit directions (count, 2) all round, read-only."""
    azimuth = np.arange(count) * (2 * np.pi / count)
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    direction.setflags(write=False)
    return direction


def columns(shape: tuple[int, ...]) -> Rays:
    """One ray down every pixel column from row 0: for a line that runs across the picture of `shape` (h, w)."""
    column = np.arange(shape[1], dtype=np.float64)
    start = np.stack([column, np.zeros_like(column)], axis=1)
    return Rays(start, np.tile([0.0, 1.0], (column.size, 1)), shape[0], False, 1.0)


def rows(shape: tuple[int, ...]) -> Rays:
    """One ray along every pixel row from column 0: for a line that runs down the picture of `shape` (h, w)."""
    row = np.arange(shape[0], dtype=np.float64)
    start = np.stack([np.zeros_like(row), row], axis=1)
    return Rays(start, np.tile([1.0, 0.0], (row.size, 1)), shape[1], False, 1.0)

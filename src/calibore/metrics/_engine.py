"""The compiled form of `findings_by_numpy`, which does not hold Python's lock; `native/src/rings` is its code."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from calibore._native import estimate_ring
from calibore.geometry import drawn_triples
from calibore.kernels import is_native
from calibore.metrics._draws import regular_size
from calibore.metrics._findings import Findings, findings_by_numpy, grid_angles
from calibore.metrics._noise import orthonormal_draws, plain_draws
from calibore.metrics._shape import RingShape
from calibore.metrics._sizes import EXTREMES, LINEAR

Array = NDArray[np.float64]

WALL = (*LINEAR, *EXTREMES, "ovality_harmonic")
CLOCKS = ("diameter_min_clock", "diameter_max_clock")


def findings_of(ring: RingShape, *, roll: float, kernel: str) -> Findings | None:
    """By `kernel`; a ring that the engine will not judge (no circle, matrices without factors) is left to the twin."""
    found = _by_engine(ring, roll) if is_native(kernel) else None
    return found or findings_by_numpy(ring, roll=roll)


def _by_engine(ring: RingShape, roll: float) -> Findings | None:
    size, drawn = regular_size(ring.clock.size), drawn_triples(int(ring.measured.sum()))
    shape = (np.sin(ring.clock), np.cos(ring.clock), ring.radius, ring.u_independent, ring.common_mode)
    rows = [np.ascontiguousarray(values, dtype=float) for values in (*shape, ring.correlation)]
    estimate = estimate_ring(*rows, drawn, _angles(size, roll), size)
    if estimate is None:
        return None
    core, again, possible = estimate.sizes()
    table = orthonormal_draws(core)
    draws = (table, *(plain_draws(len(table), more) for more in (again, possible)))
    numbers = estimate.quantities(*(half[: len(table) // 2] for half in draws)).tolist()
    pairs = list(zip(numbers[:-2:2], numbers[1:-2:2], strict=True))
    directions, ends, points, gap, features = estimate.counts()
    wall, circle, clocks = pairs[: len(WALL)], pairs[len(WALL) : -2], pairs[-2:]
    return Findings(
        scale=numbers[-2],
        wall=dict(zip(WALL, wall, strict=True)),
        clocks=dict(zip(CLOCKS, clocks, strict=True)),
        circle=(circle[0], circle[1], circle[2]),
        points=points,
        directions=directions / (size // 2),
        horizontal=all(ends[:2]),
        vertical=all(ends[2:]),
        gap=gap,
        features=features,
        excess_noise=numbers[-1],
    )


@lru_cache(maxsize=64)
def _angles(size: int, roll: float) -> Array:
    return grid_angles(size, roll)

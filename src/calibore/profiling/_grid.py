"""From some 1500 rays to the regular clock positions: weighted, with the noise that neighbouring rays share.

The radius at a clock position is the weighted mean of the points within half a step of it, each moved there along the
wall's local slope. A point that does not belong to the same piece of wall as the one nearest to the position (an edge
runs through the step) is left out, so that an edge stays an edge.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._take import TakePoints
from calibore.status import Status, has_value
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]
POSITIONS = 400
"""Clock positions (Swanbom 2007, 6.3.4.5)."""
SLOPE_REACH = 4
"""Steps on each side whose differences give the wall's local slope (their median, so that one edge does not count)."""
SAME_WALL = 5.0
"""Points further than this many standard uncertainties from the nearest one lie on another piece of wall."""
LAGS = 3
"""Steps over which the noise of neighbouring clock positions is reported as correlated."""


@dataclass(frozen=True)
class Ring:
    """One ring on the clock grid, n positions, m modes; NaN where nothing was measured.

    `radius`, `axial`, `u` (independent) (n,) [m]; `modes` (m, n) [m]; `status` (n,); `correlation` (k,) of the
    independent part at lags 1 .. k steps.
    """

    clock: Array
    radius: Array
    axial: Array
    u: Array
    modes: Array
    status: NDArray[np.uint8]
    correlation: Array


def clock_grid(positions: int = POSITIONS) -> Array:
    """Clock positions (n,) [rad] from the crown."""
    return np.asarray(np.arange(positions) * (2 * np.pi / positions), dtype=np.float64)


@dataclass(frozen=True)
class Places:
    """Where n rays fall on a regular closed grid of `count` positions, `step` apart: the nearest one, `home` (n,), and
    how far they are from it, `offset` (n,); `turn` (n,) and `by_parameters` (n, p): what a pixel along the ray and the
    rig's parameters change of that.
    """

    home: NDArray[np.intp]
    offset: Array
    turn: Array
    by_parameters: Array
    step: float
    count: int


@dataclass(frozen=True)
class Averages:
    """Weighted means at the positions of a grid, n of them; NaN where nothing was measured, as in `Ring`."""

    radius: Array
    u: Array
    modes: Array
    status: NDArray[np.uint8]
    correlation: Array
    _table: "_Table"
    _weight: Array

    def mean(self, values: Array) -> Array:
        """(n,) the same mean of another value (rays,) of the rays."""
        return np.where(np.isfinite(self.radius), self._table.mean(self._weight, values), np.nan)


def grid_ring(take: TakePoints, covariance: Covariance, *, stripe: float | None, positions: int = POSITIONS) -> Ring:
    """`take` on the clock grid. `stripe` [px]: stated standard uncertainty of a line position, if not the observed."""
    step = 2 * np.pi / positions
    home = np.rint(take.clock / step).astype(np.intp) % positions
    offset = np.mod(take.clock - home * step + np.pi, 2 * np.pi) - np.pi
    places = Places(home, offset, take.turn, take.points.clock_sensitivities.parameters, step, positions)
    at = average(take, places, covariance, stripe=stripe)
    axial = at.mean(take.points.axial)
    return Ring(clock_grid(positions), at.radius, axial, at.u, at.modes, at.status, at.correlation)


def average(take: TakePoints, places: Places, covariance: Covariance, *, stripe: float | None) -> Averages:
    """The radii of `take` at the positions of a grid, moved there along the wall's slope."""
    home, offset = places.home, places.offset
    table = _Table.of(home, has_value(take.status), places.count)
    radius, offsets = table.take(take.points.radius), table.take(offset)
    slope = local_slopes(radius, offsets, places.step)
    along = take.along - slope[home] * places.turn
    spread = np.abs(along) * take.enlargement
    sigma = table.take(spread * take.u_position)
    level = radius - slope[:, None] * offsets
    weight = _weights(level, sigma, offsets)
    u, correlation = _noise(weight, sigma, table, take.stripe.correlation)
    if stripe is not None:
        u = np.nansum(weight * table.take(spread), axis=1) * stripe
    found = weight.sum(axis=1) > 0
    gone = np.where(found, 0.0, np.nan)
    moved = take.points.radius_sensitivities.parameters - slope[home][:, None] * places.by_parameters
    sensitivities = np.stack([table.mean(weight, column) for column in moved.T], axis=1)
    modes = propagate(sensitivities, covariance, names=take.points.parameter_names).modes
    mean = np.nansum(weight * level, axis=1) + gone
    status = _status(take, home, offset, found)
    return Averages(mean, u + gone, modes + gone, status, correlation, table, weight)


@dataclass(frozen=True)
class _Table:
    """Rays sorted into clock steps: `ray` (n, k) ray numbers, -1 where a step has fewer than k."""

    ray: NDArray[np.intp]

    @classmethod
    def of(cls, home: NDArray[np.intp], usable: NDArray[np.bool_], positions: int) -> "_Table":
        rays = np.flatnonzero(usable)
        rays = rays[np.argsort(home[rays], kind="stable")]
        steps = home[rays]
        rank = np.arange(rays.size) - np.searchsorted(steps, steps)
        table = np.full((positions, int(rank.max(initial=0)) + 1), -1, dtype=np.intp)
        table[steps, rank] = rays
        return cls(table)

    def take(self, values: Array) -> Array:
        """(n, k) values of the rays, NaN where there is none."""
        return np.where(self.ray >= 0, values[self.ray], np.nan)

    def mean(self, weight: Array, values: Array) -> Array:
        """(n,) weighted mean over the rays of each step (0 where it has none)."""
        return np.sum(weight * np.where(weight > 0, values[self.ray], 0.0), axis=1)


def local_slopes(radius: Array, offsets: Array, step: float) -> Array:
    """Local slope (n,) of the wall on a closed grid, from `radius` and `offsets` (n, k): median of the differences of
    neighbouring steps.
    """
    count = np.sum(np.isfinite(radius), axis=1)
    mean = np.where(count > 0, np.nansum(radius, axis=1) / np.maximum(count, 1), np.nan)
    place = np.nansum(offsets, axis=1) / np.maximum(count, 1)
    difference = (np.roll(mean, -1) - mean) / (step + np.roll(place, -1) - place)
    wrapped = np.concatenate([difference[-SLOPE_REACH:], difference, difference[: SLOPE_REACH - 1]])
    near = np.sort(np.lib.stride_tricks.sliding_window_view(wrapped, 2 * SLOPE_REACH), axis=1)
    known = np.sum(np.isfinite(near), axis=1)
    rows = np.arange(len(near))
    low, high = np.maximum(known - 1, 0) // 2, known // 2
    return np.where(known > 1, 0.5 * (near[rows, low] + near[rows, np.minimum(high, np.maximum(known - 1, 0))]), 0.0)


def _weights(level: Array, sigma: Array, offsets: Array) -> Array:
    """Weights (n, k), summing to one, of the points on the same piece of wall as the nearest one; 0 elsewhere."""
    distance = np.where(np.isfinite(level), np.abs(offsets), np.inf)
    nearest = np.argmin(distance, axis=1)[:, None]
    reference, doubt = np.take_along_axis(level, nearest, 1), np.take_along_axis(sigma, nearest, 1)
    same = np.abs(level - reference) <= SAME_WALL * np.hypot(sigma, doubt)
    weight = np.where(same, 1 / np.maximum(sigma, 1e-12) ** 2, 0.0)
    total = weight.sum(axis=1, keepdims=True)
    return np.divide(weight, total, out=np.zeros_like(weight), where=total > 0)


def _noise(weight: Array, sigma: Array, table: _Table, correlation: Array) -> tuple[Array, Array]:
    """Standard uncertainty (n,) of the weighted means, and the correlation of neighbouring ones (LAGS,)."""
    shared = np.concatenate([[1.0], correlation, [0.0]])
    rays = int(table.ray.max()) + 1
    part = np.where(weight > 0, weight * np.where(np.isfinite(sigma), sigma, 0.0), 0.0)

    def covariance(lag: int) -> Array:
        apart = np.abs(table.ray[:, :, None] - np.roll(table.ray, -lag, axis=0)[:, None, :])
        apart = np.minimum(np.minimum(apart, np.abs(rays - apart)), shared.size - 1)
        return np.einsum("ni,nij,nj->n", part, shared[apart], np.roll(part, -lag, axis=0))

    u = np.sqrt(np.maximum(covariance(0), 0.0))
    both = [(u > 0) & (np.roll(u, -lag) > 0) for lag in range(1, LAGS + 1)]
    lags = [covariance(k)[b] / (u * np.roll(u, -k))[b] for k, b in enumerate(both, start=1)]
    return u, np.array([float(np.median(lag)) if lag.size else 0.0 for lag in lags])


def _status(take: TakePoints, home: NDArray[np.intp], offset: Array, found: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Status of each step: that of its nearest ray, of its nearest usable ray where the step has a value."""
    usable = has_value(take.status)
    order = np.argsort(np.abs(offset) + np.where(usable == found[home], 0.0, 10.0), kind="stable")[::-1]
    status = np.full(found.size, Status.NO_PEAK, dtype=np.uint8)
    status[home[order]] = take.status[order]
    status[~found & has_value(status)] = Status.NO_PEAK
    return status

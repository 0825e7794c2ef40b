"""The reference profile between its points: radius, slopes, and how well each is known there.

Linear between the four points around, along the pipe with the mean bend of a ring and its neighbours where that is more
than noise; without all four there is no value. What bends leave open counts as uncertainty. Slopes are taken over as
many points as lie on one slope, so that little noise is left in them, and how much is known.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from calibore.registration._slopes import NOISY, bend, clock_bends, slopes
from calibore.scans import Profile

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

REACHES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Clock positions on each side whose differences make a slope, as far as they agree with one."""
WIDEST = 1.6
"""Median steps of the clock grid between two positions beyond which nothing is known between them."""
BEYOND = 0.25
"""Of the rings' spacing: as far beyond an end ring its radius still counts, less and less known."""
FAR = 0.25
"""Of the radius: rings no further than that on each side may share a slope."""
TURN = 0.25
"""Of t (1 - t) times the change of the second difference from one ring to the next: a standard deviation of what a
flank does that is steepest at one ring and flat at the next."""
PARABOLA = 0.5
"""Of t (1 - t) times the second difference from ring to ring: a wall that bends at one of the rings, not evenly, is
so far from the cubic. Beside edges it may step anywhere between rings: sqrt(t (1 - t)) of the step is the
deviation then."""
SHARP = 20
"""Clock positions within which an edge tells that walls are stepped."""
EVIDENT = 3.0
"""Standard deviations of noise beyond which a bend is one."""
RESOLUTION = 0.25
"""Of the second difference round the clock: how far a radius beside an edge may be off, wherever it lies between clock
positions. A profile holds means over its clock steps, and an edge may run anywhere through one."""
INTERPOLATION_STEPS = 3
"""Times the ring next to a point is looked for anew, where axial positions vary along it."""


@dataclass(frozen=True, eq=False)
class Place:
    """What the reference is at n places: `radius` [m], its slopes `by_axial` [m/m] and `by_clock` [m/rad] with the
    variances of their noise, `variance` [m^2] of radius from noise, `missed` [m] a standard deviation of what lies
    between the points and is alike for neighbours, `modes` (q, n) [m]; NaN where it is not known.
    """

    radius: Array
    by_axial: Array
    by_clock: Array
    noise_by_axial: Array
    noise_by_clock: Array
    variance: Array
    missed: Array
    modes: Array


@dataclass(frozen=True, eq=False)
class _Between:
    """The four points of the grid around each of p places: `row`, `column`, `weight` (4, p), and how far it is from
    the ring before to the one after, `t` (p,), and from the clock position before to the one after, `s` (p,).
    """

    row: Whole
    column: Whole
    weight: Array
    t: Array
    s: Array

    def mean(self, values: Array, *, squared: bool = False) -> Array:
        """(..., p) of `values` (..., n, m); `squared`: of variances of independent values."""
        weight = self.weight**2 if squared else self.weight
        return np.einsum("kp,...kp->...p", weight, values[..., self.row, self.column])

    def from_ring_to_ring(self, values: Array) -> Array:
        """(p,) of `values` (n, m) that belong to what lies between a ring and the next."""
        return (1 - self.s) * values[self.row[0], self.column[0]] + self.s * values[self.row[0], self.column[1]]


@dataclass(frozen=True, eq=False)
class Surface:
    """The wall as `profile` has it; rings in the order of their axial positions."""

    profile: Profile

    @cached_property
    def centres(self) -> Array:
        """(n,) [m] median axial position of each ring."""
        return np.nanmedian(self.profile.axial_position, axis=1)

    @cached_property
    def clock_slopes(self) -> Array:
        """(2, n, m) [m/rad] by differences over the positions around, and the variance of their noise."""
        radius, u2 = self.profile.radius, self.profile.u_independent**2

        def pair(k: int) -> tuple[Array, float, Array, Array]:
            before, after = np.roll(radius, k, 1), np.roll(radius, -k, 1)
            variance = np.roll(u2, -k, 1) + np.roll(u2, k, 1)
            return after - before, 2 * k * self.step, variance, before + after - 2 * radius

        return slopes(map(pair, REACHES))

    @cached_property
    def axial_slopes(self) -> Array:
        """(2, n, m) [m/m] by differences from ring to ring, and the variance of their noise: symmetric about each ring,
        so that its own noise is not in them; over several rings where these are close, one-sided at the ends.
        """
        radius, u2, z = self.profile.radius, self.profile.u_independent**2, self.profile.axial_position
        count = len(radius)
        most = max(1, int(FAR * self.profile.typical_radius / max(self.profile.spacing, 1e-9)))
        rows, pairs = np.arange(count), []
        for k in (k for k in REACHES if k <= most):
            low, high = np.maximum(rows - k, 0), np.minimum(rows + k, count - 1)
            even = (k == 1) | ((high - low) == 2 * k)
            apart = np.where(even[:, None], z[high] - z[low], np.nan)
            aside = radius[high] + radius[low] - 2 * radius
            pairs.append((radius[high] - radius[low], apart, u2[high] + u2[low], aside))
        return slopes(pairs) if count > 1 else np.zeros((2, *radius.shape))

    @property
    def step(self) -> float:
        """Of the clock [rad]."""
        return float(np.median(np.diff(self.profile.clock)))

    @cached_property
    def clock_bends(self) -> Array:
        """Size (n, m) [m] of the second difference round the clock."""
        return clock_bends(self.profile)

    @cached_property
    def axial_bends(self) -> Array:
        """(n, m) [m] size of the second difference from ring to ring, at the ends that of the ring next to it."""
        radius, u = self.profile.radius, self.profile.u_independent
        if len(radius) < 3:
            return np.zeros_like(radius)
        inner = bend(radius, u, axis=0)[1:-1]
        return np.concatenate([inner[:1], inner, inner[-1:]])

    @cached_property
    def _axial_turns(self) -> Array:
        """(n, m) [m] size of the third difference from each ring to the next, as far as it is more than noise."""
        radius, u = self.profile.radius, np.nan_to_num(self.profile.u_independent)
        turns = np.zeros_like(radius)
        if len(radius) > 3:
            third = radius[3:] - 3 * radius[2:-1] + 3 * radius[1:-2] - radius[:-3]
            turns[1:-2] = np.sqrt(np.maximum(np.nan_to_num(third) ** 2 - 20 * (NOISY * u[1:-2]) ** 2, 0.0))
            turns[0], turns[-2:] = turns[1], turns[-3]
        return turns

    @cached_property
    def _edges(self) -> Array:
        """(n, m) [m] the sharpest edge round the clock near each point and on the rings next to it: a wall that has
        edges round the clock may have them along the pipe.
        """
        around = maximum_filter1d(self.clock_bends, 2 * SHARP + 1, axis=1, mode="wrap")
        return maximum_filter1d(around, 3, axis=0, mode="nearest")

    def at(self, axial: Array, clock: Array) -> Place:
        """The reference at places (p,) given by axial position [m] and clock [rad]."""
        between = self._between(axial, clock)
        by_axial, noise_by_axial = between.mean(self.axial_slopes)
        by_clock, noise_by_clock = between.mean(self.clock_slopes)
        heights, modes = self._heights(between), between.mean(self.profile.common_mode)
        radius, variance, missed = heights
        return Place(radius, by_axial, by_clock, noise_by_axial, noise_by_clock, variance, missed, modes)

    def heights(self, axial: Array, clock: Array) -> tuple[Array, Array, Array]:
        """Radius, variance of its noise, and what may be missed, only (p,)."""
        return self._heights(self._between(axial, clock))

    def _heights(self, between: "_Between") -> tuple[Array, Array, Array]:
        t, mean = between.t, between.mean
        outside = np.maximum(np.maximum(-t, t - 1), 0.0)
        inside = np.maximum(t * (1 - t), 0.0)
        bent = PARABOLA * mean(self.axial_bends) + TURN * between.from_ring_to_ring(self._axial_turns)
        along = np.where(outside > 0, outside * mean(self.axial_bends), inside * bent)
        stepped = np.sqrt(inside) * mean(np.minimum(self.axial_bends, self._edges))
        missed = np.sqrt(along**2 + stepped**2 + (RESOLUTION * mean(self.clock_bends)) ** 2)
        noise = mean(self.profile.u_independent**2, squared=True)
        return mean(self.profile.radius) + self._bent(between), noise, missed

    def _bent(self, between: "_Between") -> Array:
        """What a cubic through slopes that are means of both sides' (Catmull and Rom 1974) adds to a straight line."""
        if self.centres.size < 3:
            return np.zeros(between.t.shape)
        t = np.clip(between.t, 0.0, 1.0)
        rises, curved = self._rises, self._curved
        before, after = between.row[0], between.row[2]
        excess = np.zeros((2, *between.t.shape))
        for number, row in enumerate((before, after)):
            for column, share in ((between.column[0], 1 - between.s), (between.column[1], between.s)):
                length = self._spans[before, column]
                own = np.where(curved[row, column], self._central[row, column] * length - rises[before, column], 0.0)
                excess[number] += share * own
        return t * (1 - t) * ((1 - t) * excess[0] - t * excess[1])

    @cached_property
    def _spans(self) -> Array:
        """(n - 1, m) [m] from each ring to the next, at the same clock."""
        return np.diff(self.profile.axial_position, axis=0)

    @cached_property
    def _rises(self) -> Array:
        """(n - 1, m) [m] the same of the radius."""
        return np.diff(self.profile.radius, axis=0)

    @cached_property
    def _central(self) -> Array:
        """(n, m) [m/m] the mean of the slopes on both sides; one-sided at the ends, NaN beside gaps."""
        slopes = self._rises / self._spans
        return np.concatenate([slopes[:1], (slopes[:-1] + slopes[1:]) / 2, slopes[-1:]])

    @cached_property
    def _curved(self) -> NDArray[np.bool_]:
        """(n, m) where rings bend by more than their noise."""
        noise = np.sqrt(6) * np.nan_to_num(self.profile.u_independent, nan=np.inf)
        return (self.axial_bends > EVIDENT * noise) & np.isfinite(self._central)

    def _between(self, axial: Array, clock: Array) -> "_Between":
        row, t = self._rows(axial, clock)
        column, following, s, close = self._columns(clock)
        below = np.minimum(row + 1, self.centres.size - 1)
        t = np.where(close, t, np.nan)
        weights = np.stack([(1 - t) * (1 - s), (1 - t) * s, t * (1 - s), t * s])
        return _Between(np.stack([row, row, below, below]), np.stack([column, following] * 2), weights, t, s)

    def _rows(self, axial: Array, clock: Array) -> tuple[Whole, Array]:
        """The ring before each place, and how far it lies from there to the next (0 ... 1, a little beyond at the
        ends); NaN outside.
        """
        count = self.centres.size
        if count == 1:
            return np.zeros(np.shape(axial), dtype=np.intp), np.zeros(np.shape(axial))
        column, following, s, _ = self._columns(clock)
        z = np.where(np.isfinite(self.profile.axial_position), self.profile.axial_position, self.centres[:, None])
        row = np.clip(np.searchsorted(self.centres, axial) - 1, 0, count - 2)
        t = np.zeros(np.shape(axial))
        for _ in range(INTERPOLATION_STEPS):
            low, high = ((1 - s) * z[row + i, column] + s * z[row + i, following] for i in (0, 1))
            t = (axial - low) / (high - low)
            row = np.clip(row + (t > 1).astype(np.intp) - (t < 0), 0, count - 2)
        low, high = ((1 - s) * z[row + i, column] + s * z[row + i, following] for i in (0, 1))
        t = (axial - low) / (high - low)
        near = (t >= -BEYOND) & (t <= 1 + BEYOND)
        return row, np.where(near, t, np.nan)

    def _columns(self, clock: Array) -> tuple[Whole, Whole, Array, NDArray[np.bool_]]:
        """Clock positions before and after each place, how far between them, and whether both are neighbours."""
        grid, turn = self.profile.clock, 2 * np.pi
        clock = grid[0] + np.mod(clock - grid[0], turn)
        column = np.clip(np.searchsorted(grid, clock, side="right") - 1, 0, grid.size - 1)
        following = (column + 1) % grid.size
        apart = np.mod(grid[following] - grid[column], turn)
        return column, following, (clock - grid[column]) / apart, apart <= WIDEST * self.step

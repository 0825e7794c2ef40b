"""Dents, rails, openings: stretches that leave the smooth wall and are followed on their own.

A stretch is found by window sums of the residuals against the known noise. Inside it the wall is the smooth series plus
a Gaussian process (Matern 3/2) whose amplitude is what its neighbourhood shows and whose length is chosen by evidence,
so that an edge does not ring and a dent is not smoothed away. Points alone against both
neighbours are taken as false readings.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.metrics._noise import Noise, factor

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WINDOWS = (3, 7, 15)  # besides single points
FOUND = 5.2  # standard deviations; one false stretch in about 3000 rings of 400 points over all windows
BELONGS = 2.5
LONGEST = 240  # points handled in one solve
LENGTHS = (2.0, 5.0, 12.0)  # of the process, in clock steps
BESIDE, EDGE = 4, 3.0  # jumps on either side; an edge exceeds their median this many times
LOCAL = 5  # points over which the size of a feature is judged
LEAST_SIZE = 0.3  # of the noise
ALONE, SUPPORTED = 6.0, 3.5


@dataclass(frozen=True, eq=False)
class Feature:
    """One stretch: `points` (q,) of the ring, `columns` (g,) of the wall grid, the smoother H, what it leaves open.

    smoother (g, q): grid values from residuals; spread (g, g): factor of the posterior covariance;
    noise (q, q): factor of the noise covariance.
    """

    points: NDArray[np.intp]
    columns: NDArray[np.intp]
    smoother: Array
    spread: Array
    noise: Array


def lone_points(standardised: Array, used: Mask) -> Mask:
    """Points (n,) far off the wall whose neighbours are both on it: false readings, not wall."""
    size = np.abs(standardised)
    neighbours = np.maximum(np.roll(np.where(used, size, 0.0), 1), np.roll(np.where(used, size, 0.0), -1))
    return used & (size > ALONE) & (neighbours < SUPPORTED)


def stretches(standardised: Array, used: Mask, noise: Noise) -> Mask:
    """Points (n,) of stretches whose residuals, in units of their own noise, cannot be noise."""
    values = np.where(used, standardised, 0.0)
    seeds, candidates = np.abs(values) > FOUND, np.abs(values) > BELONGS
    doubtful = np.where(seeds, 0.0, values)  # the wall beside an edge must not be judged by what lies beyond it
    for width in WINDOWS:
        strength = np.abs(_window_sum(doubtful, width)) / np.sqrt(noise.sum_variance(width))
        seeds = seeds | (strength > FOUND)
        if width == WINDOWS[0]:
            candidates |= strength > BELONGS
    seeds &= used
    if not seeds.any():
        return seeds
    labels = _run_labels((candidates & used) | seeds)
    return np.isin(labels, labels[seeds])


def feature_between(
    points: NDArray[np.intp], columns: NDArray[np.intp], *, angles: Array, grid: Array, residuals: Array, noise: Noise
) -> Feature:
    """The process with the best evidence for `residuals` (n,) at `points`, evaluated at `grid[columns]`."""
    middle = angles[points[points.size // 2]]
    at = np.mod(angles[points] - middle + np.pi, 2 * np.pi)
    to = np.mod(grid[columns] - middle + np.pi, 2 * np.pi)
    covariance = noise.block(points)
    values = residuals[points]
    size = _local_size(values, np.diag(covariance))
    size_at_grid = np.interp(to, at, size)
    step = 2 * np.pi / noise.sigma.size
    length = step * LENGTHS[int(np.argmax([_evidence(at, values, covariance, size, step * s) for s in LENGTHS]))]
    kernel = np.outer(size, size) * matern(at[:, None] - at[None, :], length)
    to_points = np.outer(size_at_grid, size) * matern(to[:, None] - at[None, :], length)
    inverse = np.linalg.inv(kernel + covariance)
    smoother = to_points @ inverse
    left = np.outer(size_at_grid, size_at_grid) * matern(to[:, None] - to[None, :], length) - smoother @ to_points.T
    left = 0.5 * (left + left.T) + 1e-12 * np.max(size) ** 2 * np.eye(to.size)
    return Feature(points, columns, smoother, factor(left) if to.size else left, factor(covariance))


def matern(distance: Array, length: float) -> Array:
    """Matern 3/2 correlation: continuous, with continuous slope, no smoother than a bent wall."""
    scaled = np.sqrt(3.0) * np.abs(distance) / length
    return (1 + scaled) * np.exp(-scaled)


def sharp_jumps(values: Array, sigma: Array) -> Mask:
    """Where `values` (n,) round the ring step to the next one as an edge does, not as a slope: shape (n,)."""
    jumps = np.abs(np.roll(values, -1) - values)
    high = jumps > 2 * EDGE * sigma
    if not high.any():
        return high
    beside = (np.arange(jumps.size)[:, None] + np.arange(-BESIDE, BESIDE + 1)) % jumps.size
    around = np.median(jumps[beside], axis=1)
    return high & (jumps > EDGE * around)


def split_runs(mask: Mask, edges: Mask) -> list[NDArray[np.intp]]:
    """Indices of the runs of `mask` (n,) round the ring, cut after `edges` (n,), none longer than LONGEST."""
    if not mask.any():
        return []
    offset = 0 if mask.all() else int(np.flatnonzero(~mask)[0])
    rolled = np.flatnonzero(np.roll(mask, -offset))
    index = (rolled + offset) % mask.size
    runs = np.split(index, np.flatnonzero((np.diff(rolled) > 1) | edges[index[:-1]]) + 1)
    return [part for run in runs for part in np.array_split(run, -(-run.size // LONGEST))]


def _evidence(at: Array, values: Array, noise: Array, size: Array, length: float) -> float:
    lower = factor(np.outer(size, size) * matern(at[:, None] - at[None, :], length) + noise)
    return float(-0.5 * np.sum(np.linalg.solve(lower, values) ** 2) - np.log(np.abs(np.diag(lower))).sum())


def _local_size(values: Array, noise_variance: Array) -> Array:
    """Prior standard deviation (q,) of the process: what the neighbourhood shows beyond noise.

    It fades where a dent runs out, so that the wall beside it is not followed into the noise.
    """
    window = np.ones(LOCAL)
    count = np.convolve(np.ones(values.size), window)[LOCAL // 2 :][: values.size]
    power = np.convolve(values**2, window)[LOCAL // 2 :][: values.size] / count
    return np.sqrt(np.maximum(power - noise_variance, LEAST_SIZE**2 * noise_variance))


def _window_sum(values: Array, width: int) -> Array:
    half = width // 2
    total = np.cumsum(np.concatenate([[0.0], values[-half:], values, values[:half]]))
    return total[width:] - total[:-width]


def _run_labels(mask: Mask) -> NDArray[np.intp]:
    """A number from 1 for every run round the ring, 0 outside."""
    labels = np.cumsum(mask & ~np.roll(mask, 1))
    return np.where(mask, np.where(labels == 0, max(labels[-1], 1), labels), 0)

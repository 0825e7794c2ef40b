"""Several takes of one station made one ring.

Repeated images of one wall share their speckle, so their mean is not as good as 1/sqrt(n) promises. How much they share
is seen in their differences: two takes whose difference scatters with s^2 times the sum of their variances have the
correlation 1 - s^2. A take that alone contradicts all others is left out (`_consensus`).
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._consensus import agreeing
from calibore.profiling._grid import Ring
from calibore.status import Status

Array = NDArray[np.float64]
NORMAL_HALF = 0.6745
"""Median of |z| for a standard normal z."""
FEWEST = 40
"""Positions two takes must share before their correlation can be told; below that they count as one take."""
DISAGREE = 6.0
"""Takes that differ by more standard uncertainties than this disagree: half their distance becomes uncertainty."""


@dataclass(frozen=True)
class Mixture:
    """Takes made one, n positions: `radius`, independent `u`, `status` (n,); `shared`: correlation of the takes."""

    radius: Array
    u: Array
    status: NDArray[np.uint8]
    shared: float
    _weight: Array

    def mean(self, values: list[Array]) -> Array:
        """(n,) or (m, n) the weighted mean of what each take says."""
        table = np.stack(values)
        weight = self._weight if table.ndim == 2 else self._weight[:, None, :]
        sums = np.sum(np.where(weight, table, 0.0) * weight, axis=0)
        return np.where(np.isfinite(self.radius), sums, np.nan)


def take_correlation(rings: list[Ring]) -> float:
    """Correlation of the independent parts of any two of the `rings`, from their differences; 1 where too few."""
    return correlation_of(np.stack([r.radius for r in rings]), np.stack([r.u for r in rings]))


def correlation_of(values: Array, u: Array, *, otherwise: float = 1.0) -> float:
    """The same of takes with `values` and independent `u` (t, n); `otherwise` where too few positions are shared."""
    ratios = []
    for a, b in combinations(range(len(values)), 2):
        z = np.abs(values[a] - values[b]) / np.hypot(u[a], u[b])
        z = z[np.isfinite(z)]
        if z.size >= FEWEST:
            ratios.append((np.median(z) / NORMAL_HALF) ** 2)
    return float(np.clip(1 - np.mean(ratios), 0.0, 1.0)) if ratios else otherwise


def combine_takes(rings: list[Ring]) -> tuple[Ring, float]:
    """One ring out of the takes of a station, weighted by their uncertainties, and their correlation."""
    if len(rings) == 1:
        return rings[0], 1.0
    takes = mixed(*(np.stack([getattr(ring, name) for ring in rings]) for name in ("radius", "u", "status")))
    ring = Ring(
        rings[0].clock,
        takes.radius,
        takes.mean([r.axial for r in rings]),
        takes.u,
        takes.mean([r.modes for r in rings]),
        takes.status,
        np.mean([r.correlation for r in rings], axis=0),
    )
    return ring, takes.shared


def mixed(radius: Array, u: Array, statuses: NDArray[np.uint8], *, otherwise: float = 1.0) -> Mixture:
    """The takes of `radius` (t, n), NaN where they have none, weighted by their independent `u` (t, n); one that alone
    contradicts the others is left out. `otherwise`: their correlation, where they share too few positions to tell.
    """
    shared = correlation_of(radius, u, otherwise=otherwise)
    seen = agreeing(radius, u)
    radius = np.where(seen, radius, np.nan)
    weight = np.where(seen, 1 / np.maximum(u, 1e-12) ** 2, 0.0)
    total = weight.sum(axis=0)
    found = total > 0
    weight = np.divide(weight, total, out=np.zeros_like(weight), where=total > 0)
    part = np.where(seen, weight * u, 0.0)
    variance = (1 - shared) * np.sum(part**2, axis=0) + shared * np.sum(part, axis=0) ** 2
    combined = np.where(found, np.sum(np.where(weight, radius, 0.0) * weight, axis=0), np.nan)
    variance = variance + _disagreement(radius, u, combined)
    u_combined = np.where(found, np.sqrt(variance), np.nan)
    return Mixture(combined, u_combined, _status(statuses, found), shared, weight)


def _status(statuses: NDArray[np.uint8], found: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """The best of all takes (m, n); a mean that is extrapolated in part is extrapolated."""
    best = np.min(statuses, axis=0)
    partly = (statuses == Status.EXTRAPOLATED).any(axis=0)
    measured = np.where(partly, Status.EXTRAPOLATED, np.minimum(best, Status.SATURATED))
    return np.where(found, measured, best).astype(np.uint8)


def _disagreement(radius: Array, u: Array, combined: Array) -> Array:
    """Extra variance (n,) where takes contradict each other, so that the interval covers both."""
    z = np.where(np.isfinite(radius), np.abs(radius - combined) / np.maximum(u, 1e-12), 0.0)
    distance = np.where(np.isfinite(radius), np.abs(radius - combined), 0.0)
    return np.where(z.max(axis=0) > DISAGREE / np.sqrt(2), distance.max(axis=0) ** 2, 0.0)

"""Two lasers made one ring: the combination of least variance where they agree, the better one where they do not.

Why so: docs/decisions/0006-two-lasers-one-ring.md.
"""

from collections.abc import Sequence
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._grid import Ring
from calibore.status import Status
from calibore.uncertainty import least_variance_weights

Array = NDArray[np.float64]
DISAGREE = 3.0
"""Lasers that differ by more standard uncertainties of their difference than this see different pieces of wall."""

NEARBY = 0.1
"""Radii along the pipe: light that falls further apart does not measure one place, and is not averaged."""


def fuse_lasers(rings: Sequence[Ring]) -> Ring:
    """One ring out of those of several lasers, on one clock grid, with modes of the same parameters."""
    return reduce(_fuse, rings)


def least_variance_weight(a: Ring, b: Ring) -> tuple[Array, Array]:
    """Weight (n,) of `a` in the mean of least variance, within 0 ... 1, and the variance (n,) [m^2] of a - b."""
    weights = least_variance_weights(np.stack([a.u, b.u]), np.stack([a.modes, b.modes]))
    return weights[0], _variance(a) + _variance(b) - 2 * np.sum(a.modes * b.modes, axis=0)


def share_of_first(a: Ring, b: Ring) -> Array:
    """(n,) how much of the fused value is that of `a`: for least variance where both saw one wall, else 1 or 0."""
    weight, spread = least_variance_weight(a, b)
    differ = np.abs(a.radius - b.radius) > DISAGREE * np.sqrt(spread)
    apart = np.abs(a.axial - b.axial) > NEARBY * np.minimum(a.radius, b.radius)
    weight = np.where(differ | apart, _variance(a) <= _variance(b), weight)
    return np.where(_seen(a) & _seen(b), weight, _seen(a))


def _fuse(a: Ring, b: Ring) -> Ring:
    weight, seen = share_of_first(a, b), _seen(a) | _seen(b)

    def mean(of_a: Array, of_b: Array) -> Array:
        mixed = np.where(weight > 0, weight * of_a, 0.0) + np.where(weight < 1, (1 - weight) * of_b, 0.0)
        return np.where(seen, mixed, np.nan)

    part_a, part_b = (np.where(w > 0, w * ring.u, 0.0) for w, ring in ((weight, a), (1 - weight, b)))
    own = float(np.nansum(part_a**2) / max(np.nansum(part_a**2 + part_b**2), 1e-300))
    return Ring(
        a.clock,
        mean(a.radius, b.radius),
        mean(a.axial, b.axial),
        np.where(seen, np.hypot(part_a, part_b), np.nan),
        mean(a.modes, b.modes),
        _status(a, b, weight),
        own * a.correlation + (1 - own) * b.correlation,
    )


def _status(a: Ring, b: Ring, weight: Array) -> NDArray[np.uint8]:
    """The better of both; RESOLVED where they differ at one place and one was chosen; EXTRAPOLATED where the value is
    so in part.
    """
    differ = np.abs(a.radius - b.radius) > DISAGREE * np.sqrt(least_variance_weight(a, b)[1])
    better = np.minimum(a.status, b.status)
    extrapolated = (a.status == Status.EXTRAPOLATED) & (weight > 0) | (b.status == Status.EXTRAPOLATED) & (weight < 1)
    status = np.where(differ, np.maximum(better, Status.RESOLVED), better)
    return np.where(extrapolated, Status.EXTRAPOLATED, status).astype(np.uint8)


def _seen(ring: Ring) -> NDArray[np.bool_]:
    return np.isfinite(ring.radius)


def _variance(ring: Ring) -> Array:
    return ring.u**2 + np.sum(ring.modes**2, axis=0)

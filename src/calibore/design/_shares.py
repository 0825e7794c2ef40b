"""Which input makes how much of the uncertainty round the nominal wall."""

from collections.abc import Mapping

import numpy as np

from calibore.design._ring import RingPrediction
from calibore.uncertainty import Covariance

NOTHING = 1e-9


def ring_shares(ring: RingPrediction) -> dict[str, float]:
    """Fraction of the mean variance of the radius by input, over the places that measure at first order, each by the
    laser that weighs most there; correlated inputs of either sign.
    """
    sums: dict[str, float] = {}
    for number, found in enumerate(ring.predictions):
        here = ring.first_order & (ring.laser == number)
        here = np.asarray(here.any()) if found.u.ndim < here.ndim else here
        variance = np.where(here, found.u_radius**2, 0.0)
        for name, share in found.shares.items():
            sums[name] = sums.get(name, 0.0) + float(np.sum(np.where(here, share, 0.0) * variance))
    total = sum(sums.values())
    return {name: value / total for name, value in sums.items()} if total > 0 else {}


def grouped(shares: Mapping[str, float], known: Covariance) -> dict[str, float]:
    """Shares with inputs that are correlated with each other taken together, and all lasers of a kind; the largest
    first, without those that do nothing.
    """
    left, found = dict(shares), {}
    while left:
        name = next(iter(left))
        members = [other for other in _linked(name, known) if other in left]
        label = " + ".join(of_any_laser(member) for member in members)
        found[label] = found.get(label, 0.0) + sum(left.pop(member) for member in members)
    ordered = sorted(found.items(), key=lambda item: -item[1])
    return {name: share for name, share in ordered if abs(share) > NOTHING}


def of_any_laser(name: str) -> str:
    """The path without the number of the laser: "laser.1.aim" -> "laser.aim"."""
    return ".".join(part for part in name.split(".") if not part.isdigit())


def _linked(name: str, known: Covariance) -> list[str]:
    if name not in known.names:
        return [name]
    row = known.correlations[known.names.index(name)]
    return [other for other, r in zip(known.names, row, strict=True) if other == name or r != 0]

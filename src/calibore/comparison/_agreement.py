"""A measurement against a reference: how large its errors are, and whether they are as large as it says."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._difference import Difference
from calibore.errors import InputError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
COVERAGE_FACTOR = 1.96
"""Times u: half of a 95 % interval."""
BINS = 12
"""Of the radius, for errors against it."""
FEWEST = 10
"""Points in a bin below which it is not shown."""


@dataclass(frozen=True)
class OutlierRule:
    """An error beyond `limit` [m], or beyond `sigma` standard uncertainties, is an outlier and counted as such; rms and
    coverage are those of the others. Exactly one is given: the dissertation uses 0.15 in (8.4.1).
    """

    limit: float | None = None
    sigma: float | None = None

    def __post_init__(self) -> None:
        given = [value for value in (self.limit, self.sigma) if value is not None]
        if len(given) != 1 or not given[0] > 0:
            raise InputError("An outlier rule is one positive number: limit, a length, or sigma.")

    def outliers(self, value: Array, u: Array) -> Mask:
        """Which errors (n,) are."""
        return np.abs(value) > (self.limit if self.limit is not None else float(self.sigma or 0.0) * u)

    def said(self, length: Callable[[float], str]) -> str:
        return f"beyond {length(self.limit)}" if self.limit is not None else f"beyond {self.sigma:g} u"


@dataclass(frozen=True)
class Errors:
    """Of `points` errors: root mean square, mean and predicted root mean square [m], the fraction `inside` their 95 %
    intervals (|En| <= 1), `outliers` not among them. `place` [m]: radius or axial position they belong to.
    """

    place: float
    points: int
    rms: float
    mean: float
    predicted: float
    inside: float
    outliers: int


@dataclass(frozen=True, eq=False)
class Agreement:
    """`overall` errors, those of each ring (`rings`) and by radius (`by_radius`); `normalised` (n, m) errors En, over
    their expanded uncertainty; `degrees_of_freedom` that the alignment has left of the points' own; `rule` of outliers.
    """

    overall: Errors
    rings: tuple[Errors, ...]
    by_radius: tuple[Errors, ...]
    normalised: Array
    degrees_of_freedom: float
    rule: OutlierRule


def agreement(difference: Difference, rule: OutlierRule) -> Agreement:
    """What `difference`, measured minus reference, says of the measurement; eq. 8-4 of Swanbom 2007 is the rms."""
    value, u = difference.value, difference.u
    known = np.isfinite(value) & np.isfinite(u)
    if not known.any():
        raise InputError("No point of the measurement can be compared with the reference.")
    outlier = known & rule.outliers(np.nan_to_num(value), np.nan_to_num(u))
    # by the reference's radius: bins of the measured one would choose errors
    radius, axial = difference.radius - difference.value, difference.axial
    rings = [
        errors_of(value, u, known[i : i + 1], outlier[i : i + 1], rows=slice(i, i + 1), place=axial)
        for i in range(len(value))
        if known[i].any()
    ]
    edges = np.quantile(radius[known], np.linspace(0, 1, BINS + 1))
    edges[-1] = np.inf
    bins = [known & (radius >= low) & (radius < high) for low, high in pairwise(edges)]
    spent = len(difference.registration.names) / max(difference.registration.points, 1.0)
    return Agreement(
        errors_of(value, u, known, outlier, place=radius),
        tuple(rings),
        tuple(errors_of(value, u, one, outlier & one, place=radius) for one in bins if one.sum() >= FEWEST),
        value / (COVERAGE_FACTOR * u),
        float(np.count_nonzero(known) * (1 - spent)),
        rule,
    )


def errors_of(value: Array, u: Array, known: Mask, outlier: Mask, *, place: Array, rows: slice = slice(None)) -> Errors:
    """Of the `known` points of some `rows`."""
    kept = known & ~outlier
    own, own_u = value[rows][kept], u[rows][kept]
    return Errors(
        place=float(np.mean(place[rows][known])),
        points=int(np.count_nonzero(known)),
        rms=_root_mean_square(own),
        mean=float(own.mean()) if own.size else float("nan"),
        predicted=_root_mean_square(own_u),
        inside=float(np.mean(np.abs(own) <= COVERAGE_FACTOR * own_u)) if own.size else float("nan"),
        outliers=int(np.count_nonzero(outlier)),
    )


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")

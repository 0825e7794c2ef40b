"""Whether a truth lies in the region that a fit states."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.fitting._fit import Fit

Array = NDArray[np.float64]

PROBABILITY = 0.95
FEWEST = 1.0  # degrees of freedom; the moments that Kenward and Roger match do not exist near it


class Region(NamedTuple):
    """Those parameters within squared Mahalanobis distance `limit` of the estimate; `degrees_of_freedom` of F."""

    limit: float
    degrees_of_freedom: float


def mahalanobis(fit: Fit, truth: ArrayLike, *, names: Sequence[str] | None = None) -> float:
    """Squared distance of `truth` (k,) of the parameters `names`, all if left out, in standard deviations."""
    chosen = _chosen(fit, names)
    away = np.asarray(truth, dtype=float) - fit.values[chosen]
    covariance = fit.covariance[np.ix_(chosen, chosen)]
    scale = np.sqrt(np.diag(covariance))
    return float(away / scale @ np.linalg.solve(covariance / np.outer(scale, scale), away / scale))


def region(fit: Fit, *, names: Sequence[str] | None = None, probability: float = PROBABILITY) -> Region:
    """The ellipsoid of the parameters `names` that holds the truth with `probability`: scaled F of Kenward and Roger
    (1997, section 3), chi-square where the scatter is known.
    """
    from scipy.special import chdtri, fdtri

    chosen = _chosen(fit, names)
    p = chosen.size
    first, second = _doubt(fit, chosen)
    if not second > 0:
        return Region(float(chdtri(p, 1 - probability)), np.inf)
    scale, m = _scaled_f(p, first, second)
    if not (m > FEWEST and scale > 0):
        scale, m = 1.0, max(2 * p / second, FEWEST)
    return Region(float(p / scale * fdtri(p, m, probability)), m)


def region_contains(
    fit: Fit, truth: ArrayLike, *, names: Sequence[str] | None = None, probability: float = PROBABILITY
) -> bool:
    """Whether `truth` (k,) lies in the `region` of the parameters `names`."""
    return mahalanobis(fit, truth, names=names) <= region(fit, names=names, probability=probability).limit


def _chosen(fit: Fit, names: Sequence[str] | None) -> NDArray[np.intp]:
    return np.array([fit.names.index(name) for name in (fit.names if names is None else names)])


def _doubt(fit: Fit, chosen: NDArray[np.intp]) -> tuple[float, float]:
    """Kenward and Roger's A1 and A2: how well the covariance is known, in its own metric."""
    if fit.covariance_modes is None or not len(fit.covariance_modes):
        return 0.0, 0.0
    square = np.ix_(chosen, chosen)
    scale = np.sqrt(np.diag(fit.covariance)[chosen])
    over = np.outer(scale, scale)
    relative = np.linalg.solve(
        fit.covariance[square] / over, np.array([m[square] / over for m in fit.covariance_modes])
    )
    traces = np.trace(relative, axis1=1, axis2=2)
    return float(traces @ traces), float(np.einsum("kij,kji->", relative, relative))


def _scaled_f(p: int, first: float, second: float) -> tuple[float, float]:
    """Factor of the statistic (distance / p) and degrees of freedom with which it is F."""
    b = (first + 6 * second) / (2 * p)
    g = ((p + 1) * first - (p + 4) * second) / ((p + 2) * second)
    below = 3 * p + 2 * (1 - g)
    c1, c2, c3 = g / below, (p - g) / below, (p + 2 - g) / below
    mean = 1 / (1 - second / p)
    variance = 2 / p * (1 + c1 * b) / ((1 - c2 * b) ** 2 * (1 - c3 * b))
    m = 4 + (p + 2) / (p * variance / (2 * mean**2) - 1)
    return m / (mean * (m - 2)), m

"""Random deviations of correlated inputs: a Gaussian copula with the stated marginals (JCGM 101, 6.4)."""

from dataclasses import dataclass
from math import exp, inf, lgamma, sqrt

import numpy as np
from numpy.typing import NDArray

from calibore.uncertainty._distributions import Distribution, score_correlation, value_correlation

Array = NDArray[np.float64]

NO_GROUP = -1
FINITE_MEAN, FINITE_VARIANCE = 1, 2  # degrees of freedom that a t distribution must exceed to have them


@dataclass(frozen=True, eq=False)
class Scores:
    """How p inputs are drawn: scores `z = factor @ normals`, then each input's own `Distribution.deviations` times u.

    Normal inputs with finite degrees of freedom are t distributed (JCGM 101, 6.4.9): their scores are multiplied by
    sqrt(nu / chi2), with one chi2 for all inputs of one of `groups` (those correlated with each other and of equal nu,
    as the parameters of one fit: a multivariate t). Groups count from 0, NO_GROUP is none.
    `shortfall` is the largest difference between a stated correlation and the one drawn; it is not 0 where the
    distributions allow no such correlation (rectangular and normal: 0.977 at most) and the nearest possible is taken.
    """

    factor: Array
    u: Array
    distributions: tuple[Distribution, ...]
    degrees_of_freedom: Array
    groups: NDArray[np.intp]
    shortfall: float

    @property
    def codes(self) -> NDArray[np.uint8]:
        """`Distribution.code` of each input (p,)."""
        return np.array([d.code for d in self.distributions], dtype=np.uint8)

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Deviations (n, p) from the estimates; nothing is drawn for inputs without variance."""
        drawn = self.u > 0
        scores = rng.standard_normal((n, int(drawn.sum()))) @ self.factor[:, drawn].T
        for group in range(self.groups.max(initial=NO_GROUP) + 1):
            members = self.groups == group
            nu = self.degrees_of_freedom[members][0]
            scores[:, members] *= np.sqrt(nu / rng.chisquare(nu, n))[:, None]
        for i, distribution in enumerate(self.distributions):
            if distribution is not Distribution.NORMAL:
                scores[:, i] = distribution.deviations(scores[:, i])
        return scores * self.u


def scores_of(
    correlation: Array, u: Array, distributions: tuple[Distribution, ...], degrees_of_freedom: tuple[float, ...]
) -> Scores:
    """Of inputs with `correlation` (p, p) between their values and standard uncertainties `u` (p,)."""
    nu = np.array(degrees_of_freedom, dtype=float)
    is_t = np.array([d is Distribution.NORMAL for d in distributions], dtype=bool) & np.isfinite(nu) & (u > 0)
    groups = _groups(connected(correlation), nu, is_t)
    wanted, damping = correlation.copy(), np.ones_like(correlation)
    pairs = [(i, j) for i, j in np.argwhere(np.triu(correlation, 1)) if u[i] > 0 and u[j] > 0]
    for i, j in pairs:
        damping[i, j] = _damping(nu, groups, i, j)
        r = float(np.clip(correlation[i, j] / damping[i, j], -1.0, 1.0))
        wanted[i, j] = wanted[j, i] = score_correlation(distributions[i], distributions[j], r)
    factor = _factor(wanted, u > 0)
    reached = factor @ factor.T
    short = [
        abs(
            value_correlation(distributions[i], distributions[j], float(np.clip(reached[i, j], -1, 1))) * damping[i, j]
            - r
        )
        for i, j in pairs
        for r in (correlation[i, j],)
    ]
    return Scores(factor, u, distributions, nu, groups, float(max(short, default=0.0)))


def connected(matrix: Array) -> NDArray[np.intp]:
    """A label (p,) for each input: equal for those linked by entries that are not zero, directly or through others."""
    reach = (matrix != 0) | np.eye(len(matrix), dtype=bool)
    for _ in range(int(np.ceil(np.log2(len(matrix) + 1)))):
        reach = reach @ reach
    return reach.argmax(axis=1) if len(matrix) else np.zeros(0, dtype=np.intp)


def _groups(linked: NDArray[np.intp], nu: Array, is_t: NDArray[np.bool_]) -> NDArray[np.intp]:
    groups = np.full(len(nu), NO_GROUP, dtype=np.intp)
    keys: dict[tuple[int, float], int] = {}
    for i in np.flatnonzero(is_t):
        groups[i] = keys.setdefault((int(linked[i]), float(nu[i])), len(keys))
    return groups


def _damping(nu: Array, groups: NDArray[np.intp], i: int, j: int) -> float:
    """Correlation of values over that of scores: 1 within one group, less where each has its own chi2 or none."""
    if groups[i] == groups[j]:
        return 1.0
    return _shrinkage(nu[i] if groups[i] >= 0 else inf) * _shrinkage(nu[j] if groups[j] >= 0 else inf)


def _shrinkage(nu: float) -> float:
    """E(w) / sqrt(E(w^2)) of w = sqrt(nu / chi2_nu); 1 where a t distribution has no variance, hence no correlation."""
    if not FINITE_VARIANCE < nu < inf:
        return 1.0
    mean = sqrt(nu / 2) * exp(lgamma((nu - FINITE_MEAN) / 2) - lgamma(nu / 2))
    return mean / sqrt(nu / (nu - FINITE_VARIANCE))


def _factor(correlation: Array, present: NDArray[np.bool_]) -> Array:
    """(p, p) with rows of length 1 (0 where not `present`); the nearest positive semi-definite matrix if need be."""
    index = np.flatnonzero(present)
    factor = np.zeros_like(correlation)
    if index.size:
        values, vectors = np.linalg.eigh(correlation[np.ix_(index, index)])
        part = vectors * np.sqrt(np.maximum(values, 0.0))
        factor[np.ix_(index, index)] = part / np.linalg.norm(part, axis=1, keepdims=True)
    return factor

"""Is a difference more than two covariances allow: chi-square over the directions in which they allow any."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
NEGLIGIBLE = 2e-3
"""Of the largest standard deviation: motions that are smaller everywhere cannot be told from rounding."""


class Judgement(NamedTuple):
    """`chi_square` over the identifiable `directions`; `p` of a difference at least as large by chance (NaN where no
    uncertainty is stated); `unexplained`: rms of what lies in no such direction, in the unit of the difference.
    """

    chi_square: float
    directions: int
    p: float
    unexplained: float


class Evidence(NamedTuple):
    """Of a `difference` (n,): the part `linear` (n,) in the parameters, and motions by unit draws of the covariances of
    both sides, `first` (n, m) and `second` (n, m'), whose scatter rests on `degrees_of_freedom`.
    """

    difference: Array
    linear: Array
    first: Array
    second: Array
    degrees_of_freedom: tuple[float, float]

    @property
    def expected(self) -> float:
        """Root mean square that the covariances let expect."""
        return float(np.sqrt((self.first**2).sum() + (self.second**2).sum()) / np.sqrt(max(self.difference.size, 1)))

    def beside(self, other: "Evidence") -> "Evidence":
        """Both together, each in units of what it lets expect."""
        parts = zip(self[:4], other[:4], strict=True)
        sizes = self.expected or 1.0, other.expected or 1.0
        both = [np.concatenate([x / sizes[0], y / sizes[1]]) for x, y in parts]
        return Evidence(both[0], both[1], both[2], both[3], self.degrees_of_freedom)


def judged(evidence: Evidence, *, curvature: float = 0.0) -> Judgement:
    """Chi-square, or Hotelling's T^2 by the F distribution where the scatter rests on few degrees of freedom
    (Welch-Satterthwaite of both sides, each by its share in the identifiable directions).

    `curvature` [1 / unit]: directions with a standard deviation s do not count where s is below curvature s_max^2,
    the second-order effect of the largest.
    """
    root = np.sqrt(max(evidence.difference.size, 1))
    left, size, _ = np.linalg.svd(np.hstack([evidence.first, evidence.second]) / root, full_matrices=False)
    largest = float(size.max(initial=0.0))
    kept = (size > NEGLIGIBLE * largest) & (size > curvature * largest**2) & (size > 0)
    left, size = left[:, kept], size[kept]
    scores = left.T @ evidence.linear / root / size
    chi_square, directions = float(scores @ scores), int(kept.sum())
    rest = evidence.difference - left @ (left.T @ evidence.difference)
    unexplained = float(np.linalg.norm(rest) / root)
    if directions == 0:
        return Judgement(0.0, 0, float("nan") if evidence.linear.any() else 1.0, unexplained)
    shares = [((left.T @ part / root / size[:, None]) ** 2).sum() / directions for part in evidence[2:4]]
    slack = sum(share**2 / nu for share, nu in zip(shares, evidence.degrees_of_freedom, strict=True))
    return Judgement(chi_square, directions, _tail(chi_square, directions, slack), unexplained)


def _tail(chi_square: float, directions: int, slack: float) -> float:
    from scipy.special import chdtrc, fdtrc

    if slack > 0:
        return float(fdtrc(directions, 1 / slack, chi_square / directions))
    return float(chdtrc(directions, chi_square))

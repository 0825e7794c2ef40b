"""What may be known of an input: normal, rectangular, triangular or arcsine (JCGM 100, 4.3; JCGM 101, 6.4)."""

from enum import StrEnum
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

QUADRATURE = 80  # Gauss-Hermite nodes per axis: correlations to 1e-4 and better
BISECTIONS = 45


class Distribution(StrEnum):
    """The shape of an input's probability density; all are symmetric about the estimate."""

    NORMAL = "normal"
    RECTANGULAR = "rectangular"
    TRIANGULAR = "triangular"
    ARCSINE = "arcsine"

    @classmethod
    def named(cls, name: str) -> "Distribution":
        """From its name; raises InputError where there is none of it."""
        try:
            return cls(name)
        except ValueError:
            raise InputError(f"No distribution is called {name!r}; choose one of {', '.join(cls)}.") from None

    @property
    def code(self) -> int:
        """0 normal, 1 rectangular, 2 triangular, 3 arcsine: for compiled engines."""
        return list(Distribution).index(self)

    @property
    def half_width(self) -> float:
        """From the estimate to the limit, in standard uncertainties; infinite for the normal distribution."""
        return HALF_WIDTHS[self]

    def u_of_limits(self, half_width: float) -> float:
        """Standard uncertainty of what lies within -+ `half_width`: a/sqrt(3), a/sqrt(6), a/sqrt(2)."""
        if not (np.isfinite(half_width) and half_width >= 0):
            raise InputError(
                f"The half-width of limits must be finite and not negative, got {half_width}; give a >= 0."
            )
        if self is Distribution.NORMAL:
            raise InputError(
                f"A normal distribution has no limits, got +-{half_width}; give its standard uncertainty, or call the "
                "limits rectangular, triangular or arcsine."
            )
        return half_width / self.half_width

    def deviations(self, scores: Array) -> Array:
        """Deviations from the estimate, in standard uncertainties, of standard normal `scores`: increasing and odd."""
        if self is Distribution.NORMAL:
            return scores
        from scipy.special import ndtr

        if self is Distribution.ARCSINE:
            return self.half_width * np.sin(np.pi * (ndtr(scores) - 0.5))
        tail = ndtr(-np.abs(scores))
        inside = 1 - 2 * tail if self is Distribution.RECTANGULAR else 1 - np.sqrt(2 * tail)
        return np.copysign(self.half_width * inside, scores)


HALF_WIDTHS = {
    Distribution.NORMAL: np.inf,
    Distribution.RECTANGULAR: float(np.sqrt(3)),
    Distribution.TRIANGULAR: float(np.sqrt(6)),
    Distribution.ARCSINE: float(np.sqrt(2)),
}


def value_correlation(first: Distribution, second: Distribution, score_correlation: float) -> float:
    """Correlation of two values whose normal scores have `score_correlation`."""
    if first is second and (first is Distribution.NORMAL or abs(score_correlation) >= 1):
        return score_correlation
    if first is second is Distribution.RECTANGULAR:
        return float(6 / np.pi * np.arcsin(score_correlation / 2))
    nodes, weights = _hermite()
    across = score_correlation * nodes[:, None] + np.sqrt(max(1 - score_correlation**2, 0.0)) * nodes
    return float((weights * first.deviations(nodes)) @ second.deviations(across) @ weights)


@lru_cache(maxsize=4096)
def score_correlation(first: Distribution, second: Distribution, correlation: float) -> float:
    """Correlation of the normal scores that gives two values `correlation`; -+1 where no scores give so much."""
    if first is second and (first is Distribution.NORMAL or abs(correlation) >= 1):
        return float(np.clip(correlation, -1.0, 1.0))
    if first is second is Distribution.RECTANGULAR:
        return float(2 * np.sin(np.pi * correlation / 6))
    size, low, high = abs(correlation), 0.0, 1.0
    if size >= value_correlation(first, second, 1.0):
        return float(np.sign(correlation))
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if value_correlation(first, second, middle) < size else (low, middle)
    return float(np.copysign((low + high) / 2, correlation))


@lru_cache(maxsize=1)
def _hermite() -> tuple[Array, Array]:
    nodes, weights = np.polynomial.hermite_e.hermegauss(QUADRATURE)
    return nodes, weights / weights.sum()

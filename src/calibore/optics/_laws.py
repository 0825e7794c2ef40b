"""Lens laws r = k f(zenith) (Swanbom 2007, eqs. 6-1 to 6-5): f, its inverse and its slope."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.optics._odd_polynomial import OddPolynomial

Function = Callable[[NDArray[Any]], NDArray[Any]]


@dataclass(frozen=True)
class LensLaw:
    """`ratio` = r / k of the zenith [rad]; `zenith` its inverse; `slope` = d ratio / d zenith, by the ratio.

    The law holds for zenith < `max_zenith` and ratio < `max_ratio`. `powers`: the exponents of zenith whose
    coefficients are parameters of the law (polynomial only).
    """

    ratio: Function
    zenith: Function
    slope: Function
    max_zenith: float
    max_ratio: float
    powers: tuple[int, ...] = ()


LENS_LAWS: dict[str, LensLaw] = {
    "perspective": LensLaw(np.tan, np.arctan, lambda q: 1 + q * q, np.pi / 2, np.inf),
    "stereographic": LensLaw(
        lambda zenith: np.tan(zenith / 2), lambda q: 2 * np.arctan(q), lambda q: (1 + q * q) / 2, np.pi, np.inf
    ),
    "equidistant": LensLaw(lambda zenith: zenith, lambda q: q, np.ones_like, np.pi, np.pi),
    "sine-law": LensLaw(np.sin, np.arcsin, lambda q: np.sqrt(1 - q * q), np.pi / 2, 1.0),
    "equisolid-angle": LensLaw(
        lambda zenith: np.sin(zenith / 2), lambda q: 2 * np.arcsin(q), lambda q: np.sqrt(1 - q * q) / 2, np.pi, 1.0
    ),
}
LENS_NAMES = (*LENS_LAWS, "polynomial")


def polynomial_law(coefficients: tuple[float, ...]) -> LensLaw:
    """The law r = k (zenith + p3 zenith^3 + p5 zenith^5 + ...) with `coefficients` (p3, p5, ...)."""
    series = OddPolynomial(coefficients)
    max_zenith = min(series.limit, np.pi)
    return LensLaw(
        series.value,
        series.inverse,
        lambda q: series.slope(series.inverse(q)),
        max_zenith,
        float(np.real(series.value(np.array(max_zenith)))),
        tuple(range(3, 3 + 2 * len(coefficients), 2)),
    )

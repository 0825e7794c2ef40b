"""The odd polynomial y = x + c3 x^3 + c5 x^5 + ..., on the stretch from 0 where it rises, and its inverse."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEAST_SLOPE = 0.05  # of the slope at 0; nearer to its turning point a polynomial describes no lens
FARTHEST = 100.0  # half image heights, or radians: farther out than any image
NEGLIGIBLE = 1e-12  # of the slope at 0
STEPS = 12
HALVINGS = 60
CONVERGED = 1e-14
SETTLED = 1e-9


@dataclass(frozen=True)
class OddPolynomial:
    """`coefficients` = (c3, c5, ...)."""

    coefficients: tuple[float, ...]

    @cached_property
    def limit(self) -> float:
        """The largest x up to which the slope stays above `LEAST_SLOPE`; at most `FARTHEST`."""
        slope = np.array([np.real(c) * (2 * i + 3) for i, c in enumerate(self.coefficients)])
        slope[np.abs(slope) * FARTHEST ** (2.0 * np.arange(1, slope.size + 1)) < NEGLIGIBLE] = 0.0
        roots = np.roots([*slope[::-1], 1 - LEAST_SLOPE])  # in x^2
        turning = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
        return float(np.sqrt(turning.min(initial=FARTHEST**2)))

    def value(self, x: NDArray[Any]) -> NDArray[Any]:
        square = x * x
        total = np.zeros_like(square)
        for c in reversed(self.coefficients):
            total = (total + c) * square
        return x * (1 + total)

    def slope(self, x: NDArray[Any]) -> NDArray[Any]:
        square = x * x
        total = np.zeros_like(square)
        for i, c in reversed(tuple(enumerate(self.coefficients))):
            total = (total + (2 * i + 3) * c) * square
        return 1 + total

    def inverse(self, y: NDArray[Any]) -> NDArray[Any]:
        """The x in [0, limit] with value(x) = y, by Newton from x = y; NaN where there is none."""
        y = np.where((np.real(y) >= 0) & (np.real(y) <= np.real(self.value(np.array(self.limit)))), y, np.nan)
        x, settled = self._newton(np.where(np.real(y) <= self.limit, y, self.limit), y)
        inside = (np.real(x) >= -SETTLED) & (np.real(x) <= self.limit + SETTLED)
        lost = ~(settled & inside | np.isnan(y))
        if lost.any():  # an inflection on the way threw Newton off
            x[lost] = self._newton(self._bisected(np.real(y[lost])), y[lost])[0]
        return x

    def _newton(self, x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.bool_]]:
        step = np.zeros_like(x)
        with np.errstate(all="ignore"):  # a point thrown off may run away; `inverse` brings it back
            for _ in range(STEPS):
                step = (self.value(x) - y) / self.slope(x)
                x = x - step
                if not np.nanmax(np.abs(step), initial=0.0) > CONVERGED:
                    break
        return x, np.abs(step) <= SETTLED

    def _bisected(self, y: NDArray[Any]) -> NDArray[Any]:
        low, high = np.zeros_like(y), np.full_like(y, self.limit)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            below = self.value(middle) < y
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return (low + high) / 2

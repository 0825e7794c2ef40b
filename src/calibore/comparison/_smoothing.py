"""Means over windows of a difference, with their uncertainty: small changes show in means before they do in points."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._difference import LEAST_SCATTER, Difference

Array = NDArray[np.float64]

CLOCKS = (3, 7, 15, 31)
"""Clock positions of the windows; a single point, however far off, is dirt or a stray peak before it is a change."""
RINGS = (1, 3, 7, 15)
"""Rings of the windows, where rings are close."""
CLOSE = 0.05
"""Of the radius: rings that are no further apart than this are close."""
FILLED = 0.5
"""Of a window that must be known."""
PLAIN = 4.0
"""Standard deviations within which a difference is noise."""
FEWEST = 200
"""Pairs of points on neighbouring rings from which their correlation is told."""
MOST_ACROSS = 0.45
"""Noise of which each ring shares half with the next on either side."""


@dataclass(frozen=True)
class Window:
    """`rings` times `clocks` points."""

    rings: int
    clocks: int


def windows_of(difference: Difference) -> tuple[Window, ...]:
    """From a point to as much as a usual defect covers."""
    axial = np.sort(np.nanmedian(difference.axial, axis=1))
    spacing = float(np.median(np.diff(axial))) if axial.size > 1 else np.inf
    close = spacing <= CLOSE * float(np.nanmedian(difference.radius))
    several = [rings for rings in (RINGS if close else RINGS[:1]) if FILLED * rings <= axial.size]
    return tuple(Window(rings, clocks) for rings in several for clocks in CLOCKS)


@dataclass(frozen=True, eq=False)
class Smoother:
    """Weighted means of fields (..., n, m) over windows. Noise of `variance` (n, m), NaN where not known, is correlated
    along the clock by `correlation` (k,) and with the next ring by `across`, and averages out; `missed` (n, m), alike
    for neighbours, and common `modes` (q, n, m) do not.
    """

    variance: Array
    missed: Array
    modes: Array
    correlation: Array
    across: float

    @classmethod
    def of(cls, difference: Difference) -> "Smoother":
        scatter = max(difference.registration.scatter, LEAST_SCATTER)
        variance = np.where(np.isfinite(difference.adjusted), (difference.u_independent * scatter) ** 2, np.nan)
        modes, correlation = np.nan_to_num(difference.adjusted_modes), difference.registration.correlation
        return cls(variance, np.nan_to_num(difference.missed), modes, correlation, _across(difference))

    @cached_property
    def _weight(self) -> Array:
        total = self.variance + self.missed**2
        return np.where(np.isfinite(total), 1 / np.where(total > 0, total, np.inf), 0.0)

    def mean(self, field: Array, window: Window) -> Array:
        """(..., n, m), NaN where less than half of the window is known."""
        return _sums(np.nan_to_num(field) * self._weight, window) / self._total(window)

    def u(self, window: Window) -> Array:
        """Standard uncertainty (n, m) of the mean."""
        squares = _sums(self._weight**2 * np.nan_to_num(self.variance), window)
        noise = self._effect(window) * squares / self._total(window) ** 2
        common = np.sum(self.mean(self.modes, window) ** 2, axis=0)
        return np.sqrt(noise + self.mean(self.missed, window) ** 2 + common)

    @cached_property
    def _totals(self) -> dict[Window, Array]:
        return {}

    def _total(self, window: Window) -> Array:
        """Sum (n, m) of the weights, NaN where less than half of the window is known."""
        if window not in self._totals:
            known = _sums((self._weight > 0).astype(float), window) >= FILLED * window.rings * window.clocks
            total = _sums(self._weight, window)
            self._totals[window] = np.where(known & (total > 0), total, np.nan)
        return self._totals[window]

    def _effect(self, window: Window) -> float:
        """By how much correlated neighbours enlarge the variance of a mean of so many."""
        lags = np.arange(1, min(window.clocks, self.correlation.size + 1))
        around = 1 + 2 * float(np.sum((1 - lags / window.clocks) * self.correlation[: lags.size]))
        return max(around, 0.1) * (1 + 2 * (1 - 1 / window.rings) * self.across)


def _across(difference: Difference) -> float:
    """Correlation of noise with the next ring's: rings of one survey that fall beside the same ring of the other share
    its noise.
    """
    relative = difference.adjusted / difference.u_independent
    plain = (np.abs(relative) < PLAIN) & (np.nan_to_num(difference.missed) < difference.u_independent)
    relative = np.where(plain, relative, 0.0)
    both = np.count_nonzero(plain[1:] & plain[:-1])
    if both < FEWEST:
        return 0.0
    alone = np.sum(relative**2) / np.count_nonzero(plain)
    return float(np.clip(np.sum(relative[1:] * relative[:-1]) / both / alone, 0.0, MOST_ACROSS))


def _sums(field: Array, window: Window) -> Array:
    """Over the window around each place; the clock goes round, the ends of the pipe do not."""
    half, m = window.clocks // 2, field.shape[-1]
    around = np.concatenate([field[..., m - half :], field, field[..., :half]], axis=-1) if half else field
    along = window.rings // 2
    padded = np.pad(around, [(0, 0)] * (field.ndim - 2) + [(along, along), (0, 0)])
    sums = np.cumsum(np.pad(padded, [(0, 0)] * (field.ndim - 1) + [(1, 0)]), axis=-1)
    sums = sums[..., window.clocks :] - sums[..., : -window.clocks]
    sums = np.cumsum(np.pad(sums, [(0, 0)] * (field.ndim - 2) + [(1, 0), (0, 0)]), axis=-2)
    return sums[..., window.rings :, :] - sums[..., : -window.rings, :]

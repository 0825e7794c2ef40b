"""How large the largest deviation of an unchanged pipe would be by chance."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._difference import Difference
from calibore.comparison._smoothing import Smoother, Window

Array = NDArray[np.float64]

MAPS = 200
"""Unchanged maps that are drawn."""
ALIKE = 31
"""Clock positions over which what is missed between points is alike."""
FREEDOM = 25.0
"""Of the noise of a point, whose uncertainty was itself learnt from the picture: errors over u of 38 000 points on the
plain wall of the experiment's scans have the tails of Student's distribution with 25 to 30 degrees of freedom."""
EULER = 0.5772156649
"""Mean of the standard Gumbel distribution."""


def thresholds(
    difference: Difference,
    smoother: Smoother,
    windows: tuple[Window, ...],
    *,
    false_alarm: float,
    rng: np.random.Generator,
) -> dict[Window, float]:
    """Standard uncertainties, by window, that the mean over any of them, anywhere, exceeds with probability
    `false_alarm` though nothing has changed.

    Large windows are fewer than small ones, so their limit is lower: each size alone would raise an alarm equally
    often. Maxima of drawn maps follow Gumbel's distribution (Gumbel 1958); its quantile is steadier than theirs.
    """
    every, drawn = {window: smoother.u(window) for window in windows}, _maps(difference, smoother)
    scales = {window: u for window, u in every.items() if np.isfinite(u).any()}
    largest = np.array([_largest(smoother, scales, drawn(rng)) for _ in range(MAPS)])
    alone = np.array([_exceeded(column, false_alarm) for column in largest.T])
    together = _exceeded(np.max(largest / alone, axis=1), false_alarm)
    return dict(zip(scales, (together * alone).tolist(), strict=True))


def _exceeded(maxima: Array, probability: float) -> float:
    """What maxima like these (k,) exceed with this probability."""
    spread = np.sqrt(6) / np.pi * maxima.std(ddof=1)
    return float(maxima.mean() - EULER * spread - spread * np.log(-np.log1p(-probability)))


def _largest(smoother: Smoother, scales: dict[Window, Array], field: Array) -> list[float]:
    """By window, in its standard uncertainties `scales`."""
    return [float(np.nanmax(np.abs(smoother.mean(field, window)) / u)) for window, u in scales.items()]


def _maps(difference: Difference, smoother: Smoother) -> Callable[[np.random.Generator], Array]:
    """What draws maps (n, m) of an unchanged pipe: noise, what is missed and calibration errors, fitted as the
    difference was, for the fit takes its part of the noise away. Where rings move alone, with what is left common.
    """
    registration = difference.registration
    if registration.drift is not None:
        return lambda rng: _own(smoother, rng) + np.tensordot(rng.normal(size=len(smoother.modes)), smoother.modes, 1)
    table, weight = np.nan_to_num(registration.table), registration.weights / registration.scatter**2
    weight = np.where(weight > 0, weight / registration.gaps.total, 0.0)
    solved = table.shape[1] - len(registration.modes)
    prior = np.diag(np.where(np.arange(table.shape[1]) < solved, 0.0, 1.0))
    normal = table.T @ (weight[:, None] * table) + prior
    scale = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    inverse = scale[:, None] * np.linalg.pinv(normal * np.outer(scale, scale)) * scale
    ring, position = registration.cloud.ring, registration.cloud.position

    def drawn(rng: np.random.Generator) -> Array:
        field = _own(smoother, rng)
        points = field[ring, position] + table[:, solved:] @ rng.normal(size=len(registration.modes))
        field[ring, position] = points - table @ (inverse @ (table.T @ (weight * points)))
        return field

    return drawn


def _own(smoother: Smoother, rng: np.random.Generator) -> Array:
    return _noise(smoother, rng) + _missed(smoother, rng)


def _missed(smoother: Smoother, rng: np.random.Generator) -> Array:
    """(n, m) what lies between points, of one sign over a stretch of wall."""
    n, m = smoother.missed.shape
    pieces = max(m // ALIKE, 1)
    return smoother.missed * np.repeat(rng.normal(size=(n, pieces)), -(-m // pieces), axis=1)[:, :m]


def _noise(smoother: Smoother, rng: np.random.Generator) -> Array:
    """(n, m) of the stated variance, correlated along the clock and with the next ring, with Student's tails."""
    n, m = smoother.variance.shape
    row = np.zeros(m)
    row[0] = 1.0
    lags = np.arange(1, min(smoother.correlation.size, m // 2 - 1) + 1)
    row[lags] = row[-lags] = smoother.correlation[: lags.size]
    power = np.maximum(np.fft.rfft(row).real, 0.0)
    white = rng.normal(size=(n + 1, m))
    share = 2 * smoother.across / (1 + np.sqrt(1 - 4 * smoother.across**2))  # share / (1 + share^2) = across
    rings = np.fft.rfft((white[:-1] + share * white[1:]) / np.hypot(1.0, share), axis=1)
    noise = np.fft.irfft(rings * np.sqrt(power), n=m, axis=1)
    tails = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, size=(n, m)))
    return noise * tails * np.sqrt(np.nan_to_num(smoother.variance))

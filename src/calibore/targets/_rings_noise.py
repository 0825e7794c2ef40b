"""How noisy a picture is, learnt from what the fitted lines leave over."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

LEAST_VARIANCE = 1e-8
"""Of full scale squared: a noiseless picture with 16 bit is no better."""
GROUPS, CHI_MEDIAN = 12, 0.4549
"""Groups of brightness; median of chi-square with one degree of freedom."""
OUTLYING_SQUARE = 20.0
"""Squared residuals beyond this multiple of the variance tell of dirt, not of noise."""
ROUNDS = 3


@dataclass(frozen=True)
class Noise:
    """Variance of a pixel of brightness m: `additive` + `gain` m."""

    additive: float
    gain: float

    def variance(self, brightness: Array) -> Array:
        return np.maximum(self.additive + self.gain * brightness, LEAST_VARIANCE)


def learn_noise(predicted: Array, square: Array) -> Noise:
    """The noise that squared residuals (n,) show, as a straight line over the `predicted` brightness: first by the
    medians of equally many pixels of like brightness, which dirt does not move, then by all pixels but the outlying.
    """
    order = np.argsort(predicted)
    groups = np.array_split(order, min(GROUPS, max(2, predicted.size // 50)))
    level = np.array([predicted[group].mean() for group in groups])
    typical = np.array([np.median(square[group]) for group in groups]) / CHI_MEDIAN
    noise = _straight(level, typical, typical)
    for _ in range(ROUNDS):
        variance = noise.variance(predicted)
        kept = square < OUTLYING_SQUARE * variance
        noise = _straight(predicted[kept], square[kept], variance[kept])
    return noise


def _straight(level: Array, square: Array, variance: Array) -> Noise:
    """The straight line through squared residuals whose own scatter is as their expected `variance`."""
    design = np.stack([np.ones(level.size), level], axis=1) / (variance + LEAST_VARIANCE)[:, None]
    additive, gain = np.linalg.lstsq(design, square / (variance + LEAST_VARIANCE), rcond=None)[0]
    if gain < 0:
        return Noise(float(np.mean(square)), 0.0)
    return Noise(float(additive), float(gain))

"""The sub-pixel place of a peak and its uncertainty, as `native/src/stripe/{batch,fit,refine,literature}.rs`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import SATURATED_FROM, Estimator, ScanSettings

Array = NDArray[np.float64]
LONGEST_STEP = 2.0
"""A Gauss-Newton step longer than this [px] has left the peak: the zero crossing is kept, the step is its doubt."""
SINGULAR = 1e-12
"""Least determinant, relative to its diagonal, at which the samples still fix a place."""


@dataclass(frozen=True)
class Standing:
    """A peak that stands out: zero crossing `position` of the slope, the `fraction` of it between two windows,
    `height` and mean `background` of both sides [grey values], places of half height `rise` and `fall`.
    """

    position: float
    fraction: float
    height: float
    background: float
    rise: float
    fall: float


def refine(y: Array, peak: Standing, settings: ScanSettings) -> tuple[float, float] | None:
    """(position, u) of `peak` on a ray of samples `y` (m,) by the estimator asked for; None where it finds none."""
    if settings.estimator in (Estimator.CROSSING, Estimator.STEGER):  # Steger's looks at the picture, not at the ray
        return peak.position, 0.0
    middle = int(peak.position + 0.5)
    low, high = max(middle - settings.half_fit, 0), min(middle + settings.half_fit, y.size - 1)
    x, window = np.arange(low, high + 1, dtype=np.float64), y[low : high + 1]
    good = np.isfinite(window)
    x, window = x[good], window[good]
    functional, moved = _gauss_newton(x, window, peak, settings)
    u = _uncertainty(x, functional, peak, settings)
    match settings.estimator:
        case Estimator.ZERO_CROSSING:
            kept = abs(moved) <= LONGEST_STEP
            span = peak.fall - peak.rise  # so far it may be off at most
            u = min(u, span)
            return (peak.position + moved, u) if kept else (peak.position, float(np.hypot(u, min(abs(moved), span))))
        case Estimator.PARABOLA:
            place = _parabola(y, peak, settings)
            return None if place is None else (place, u)
        case Estimator.MAXIMUM:
            return float(x[np.argmax(window)]), float(np.hypot(u, np.sqrt(1 / 12)))
        case Estimator.THRESHOLD:
            return 0.5 * (peak.rise + peak.fall), u
        case Estimator.CENTROID:
            weight = np.maximum(window - peak.background, 0.0)
            return float(np.sum(weight * x) / np.sum(weight)), u
        case _:
            return peak.position + _correlation(x, window - peak.background, peak.position, settings), u


def _gauss_newton(x: Array, window: Array, peak: Standing, settings: ScanSettings) -> tuple[Array | None, float]:
    """Linear functional (m,) of the samples that moves the peak, and the step it gives; None if they fix no place.

    One weighted Gauss-Newton step of y = amplitude exp(-(x - position)^2 / 2 width^2) + background in its three
    unknowns, weights 1 / V(brightness), saturated samples left out.
    """
    noise = settings.noise
    shape = np.exp(-((x - peak.position) ** 2) / (2 * noise.width**2))
    line = peak.height * shape
    weight = np.where(window >= SATURATED_FROM * settings.white, 0.0, 1 / noise.variance(line))
    jacobian = np.stack([shape, line * (x - peak.position) / noise.width**2, np.ones_like(x)])
    normal = (jacobian * weight) @ jacobian.T
    if not np.linalg.det(normal) > SINGULAR * normal[0, 0] * normal[1, 1] * normal[2, 2]:
        return None, 0.0
    functional = np.linalg.inv(normal)[1] @ (jacobian * weight)
    return functional, float(functional @ (window - line - peak.background))


def _uncertainty(x: Array, functional: Array | None, peak: Standing, settings: ScanSettings) -> float:
    """Standard uncertainty [px] of `functional` under pixel noise (white) and speckle (correlated over its grain).

    For the weights 1 / V this is the inverse Fisher information, corrected for the correlation of the speckle. Where
    the samples fix no place (a saturated plateau), the line may be anywhere within its full width at half height.
    """
    if functional is None:
        return float((peak.fall - peak.rise) / np.sqrt(12))
    noise = settings.noise
    line = peak.height * np.exp(-((x - peak.position) ** 2) / (2 * noise.width**2))
    white = np.sum(functional**2 * (noise.additive + noise.gain * line))
    speckled = functional * line
    distance = np.abs(x[:, None] - x).astype(np.intp)
    shared = noise.correlation(2 * settings.half_fit + 1)[distance]
    return float(np.sqrt(max(white + noise.contrast * speckled @ shared @ speckled, 0.0)))


def _parabola(y: Array, peak: Standing, settings: ScanSettings) -> float | None:
    """Vertex of the parabola fitted to the window nearest to the crossing (Swanbom 2007, 6.3.4.2)."""
    w = settings.window
    first = round(peak.position - peak.fraction - (w - 1) / 2) + (1 if peak.fraction > 0.5 else 0)
    lever = np.arange(w) - (w - 1) / 2
    square = lever**2 - np.mean(lever**2)
    slope = y[first : first + w] @ lever / np.sum(lever**2)
    bend = y[first : first + w] @ square / np.sum(square**2)
    return float(first + (w - 1) / 2 - slope / (2 * bend)) if bend < 0 else None


def _correlation(x: Array, window: Array, position: float, settings: ScanSettings) -> float:
    """Offset [px] from `position` of the best match with a Gaussian of the line's width, by two Newton steps."""
    variance, offset = settings.noise.width**2, 0.0
    for _ in range(2):
        z = x - position - offset
        shape = np.exp(-(z**2) / (2 * variance))
        first, second = np.sum(window * shape * z), np.sum(window * shape * (z**2 / variance - 1))
        offset += float(np.clip(-first / second, -1.0, 1.0)) if second < 0 else 0.0
    return offset

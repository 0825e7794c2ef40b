"""How noisy the picture is, learnt from the picture itself.

A sample of brightness m above background scatters with variance V(m) = additive + gain m + contrast m^2: read noise and
quantisation, photon (shot) noise, and speckle. Speckle is correlated over its grain: two samples d apart on a ray share
rho(d) = exp(-d^2 / (4 grain^2)) of it. For a Gaussian line of width s seen through a blur b that form is exact, with
1/grain^2 = 1/b^2 - 1/s^2; the blur is read off along the ring, where nothing but blur correlates the brightness.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""
CHI_MEDIAN = 0.4549
"""Median of chi-square with one degree of freedom, over its mean: robust against edges."""
QUANTISATION = 1 / 12
"""Variance of rounding to whole grey values."""
ALIGNED = 0.985
"""Cosine of the angle (10 deg) within which a line counts as running along pixel rows or columns."""
FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
"""Passes pixel noise, stops anything the optics have blurred by 0.8 px or more."""
FEWEST_RUNS = 200
"""Runs of five pixels needed to learn pixel noise."""
RUNS_PER_BIN, FEWEST_BINS, MOST_BINS = 60, 4, 24
FAINT_RUNS = 0.05
"""The background is the level that this fraction of the runs stays below."""
FORGOTTEN = 6.0
"""Brightness is independent beyond this many line widths along the line."""
FEWEST_PAIRS = 16
"""Pairs of rays needed to learn speckle."""
USUAL_CONTRAST = 0.04
"""Speckle contrast (variance over squared mean) before it is learnt."""
FAINTEST_HEIGHT = 1e-3
"""Heights [grey values] below this count as this."""
LEAST_SHARED, MOST_SHARED = 0.05, 0.95
"""Limits of the correlation between neighbouring rays that can be told from none and from all."""
WIDEST_BLUR = 0.95
"""The blur is at most this fraction of the line width."""
LEAST_CONTRAST, MOST_CONTRAST, LONGEST_GRAIN = 1e-6, 1.0, 1e3
"""Limits of the learnt speckle; grain in pixels."""


@dataclass(frozen=True)
class NoiseModel:
    """Variance model in grey values, line `width` (Gaussian sigma) and speckle `grain` in pixels."""

    additive: float = 1.0
    gain: float = 0.05
    contrast: float = USUAL_CONTRAST
    width: float = 1.5
    grain: float = 1.5

    def variance(self, brightness: Array) -> Array:
        return self.additive + self.gain * brightness + self.contrast * brightness**2

    def correlation(self, count: int) -> Array:
        """Speckle correlation rho at sample distances 0 .. count - 1."""
        return np.exp(-(np.arange(count) ** 2) / (4 * self.grain**2))


def background_noise(difference: NDArray[np.floating], known: NDArray[np.bool_]) -> float:
    """Robust standard deviation [grey values] of pixel noise from `difference`s of nearby pixels where `known`."""
    sample = np.abs(difference[known])
    middle = float(np.partition(sample, sample.size // 2)[sample.size // 2]) if sample.size else 0.0
    return max(NORMAL * middle / np.sqrt(2), np.sqrt(QUANTISATION))


def pixel_noise(plane: NDArray[np.generic], column: Array, row: Array, direction: Array) -> tuple[float, float]:
    """(additive, gain) of the pixel noise near the line, from fourth differences of raw pixels along the line.

    Only where the line runs along pixel rows or columns: across it, the line itself is not smooth at this scale.
    `column`, `row` (n,) [px] of peaks, `direction` (n, 2) of their rays. (0, 0) where too few peaks lie so.
    """
    height, width = plane.shape
    reach, beside = np.arange(-2, 3), np.arange(-4.0, 5.0, 2.0)
    five = []
    for axis in (0, 1):
        aligned = np.abs(direction[:, 1 - axis]) > ALIGNED
        at = [column[aligned][:, None] + (beside if axis else 0.0), row[aligned][:, None] + (0.0 if axis else beside)]
        c, r = (
            np.clip(np.rint(a + 0.0 * beside), 2, n - 3).astype(np.intp).ravel()[:, None]
            for a, n in zip(at, (width, height), strict=True)
        )
        five.append(plane[r, c + reach] if axis == 0 else plane[r + reach, c])
    runs = np.concatenate(five).astype(np.float64)
    if len(runs) < FEWEST_RUNS:
        return 0.0, 0.0
    square = (runs @ FOURTH_DIFFERENCE) ** 2 / np.sum(FOURTH_DIFFERENCE**2)
    level = runs.mean(axis=1)
    terms = _variance_terms(level - np.quantile(level, FAINT_RUNS), square)
    return float(terms[0]), float(terms[1])


def _variance_terms(level: Array, square: Array) -> Array:
    """Non-negative (additive, gain, leak), E[square] = additive + gain level + leak level^2, from binned medians; what
    is darker than the background (`level` < 0) counts as this.
    """
    order = np.argsort(level, kind="stable")
    bins = np.array_split(order, int(np.clip(level.size // RUNS_PER_BIN, FEWEST_BINS, MOST_BINS)))
    mean = np.array([np.maximum(level[b], 0.0).mean() for b in bins])
    variance = np.array([np.median(square[b]) / CHI_MEDIAN for b in bins])
    design = np.stack([np.ones_like(mean), mean, mean**2], axis=1) / (variance + QUANTISATION)[:, None]
    target = variance / (variance + QUANTISATION)
    return nonnegative_least_squares(design, target)


def nonnegative_least_squares(design: Array, target: Array) -> Array:
    """The x >= 0 with the least |design x - target|, for a few columns, by trying every set of columns."""
    count = design.shape[1]
    best, answer = float(target @ target), np.zeros(count)
    for size in range(1, count + 1):
        for chosen in combinations(range(count), size):
            x, *_ = np.linalg.lstsq(design[:, chosen], target, rcond=None)
            misfit = float(np.sum((design[:, chosen] @ x - target) ** 2))
            if np.all(x >= 0) and misfit < best:
                best, answer = misfit, np.zeros(count)
                answer[list(chosen)] = x
    return answer


def speckle(model: NoiseModel, height: Array, *, spacing: float) -> NoiseModel:
    """`model` with contrast and grain learnt from peak `height` (n,), NaN where missing, of neighbouring rays.

    Relative brightness is compared between rays: close pairs give the blur along the ring, distant ones the contrast.
    """
    logarithm = np.log(np.maximum(height, FAINTEST_HEIGHT))
    far = max(1, int(np.ceil(FORGOTTEN * model.width / spacing)))
    spread = _pair_variance(logarithm, far)
    near = _pair_variance(logarithm, max(1, round(1.0 / spacing)))
    shared = float(np.clip(1 - near / max(spread, 1e-12), LEAST_SHARED, MOST_SHARED))
    lag = max(1, round(1.0 / spacing)) * spacing
    blur = min(lag / np.sqrt(-4 * np.log(shared)), WIDEST_BLUR * model.width)
    grain = 1 / np.sqrt(1 / blur**2 - 1 / model.width**2)
    return replace(
        model, contrast=float(np.clip(spread, LEAST_CONTRAST, MOST_CONTRAST)), grain=float(min(grain, LONGEST_GRAIN))
    )


def _pair_variance(values: Array, lag: int) -> float:
    """Half the robust variance of the differences of values `lag` rays apart."""
    difference = values[lag:] - values[:-lag]
    difference = difference[np.isfinite(difference)]
    if difference.size < FEWEST_PAIRS:
        return USUAL_CONTRAST
    return float((NORMAL * np.median(np.abs(difference))) ** 2 / 2)

"""The place of a dark line across a strip: a blurred bar of ink on paper, fitted to the pixels of each bin.

brightness(t) = b (1 + g t) (1 - c bar(t - t0; w, s)),  bar(x; w, s) = Phi((x + w/2) / s) - Phi((x - w/2) / s)

t [px] across the line. Each bin has its own paper brightness b, ink width w [px] and place t0 [px]; blur s [px], ink
contrast c and the slope of the light g(along the line) [1/px] belong to the whole line. t0 is the midpoint of the two
ink edges in the picture: symmetric errors of w, s, c do not move it, the slope of the light multiplies paper and ink.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Whole
from calibore.targets._rings_strips import Strip

Array = NDArray[Any]

STEPS, SETTLED = 12, 1e-4
"""At most so many Gauss-Newton steps, until no place moves by more [px]."""
LONGEST_STEP, NARROWEST = 0.5, 0.1
"""px: of place and width in one step; width below which expectations are equally unsure."""
LONGEST_SHARED = 0.1
"""px of blur, and fraction of contrast, in one step."""
SLOPE_PRIOR = 0.01
"""Standard uncertainty of the light's slope [1/px]."""
WIDTH_PRIOR = 0.5
"""Standard uncertainty of a bin's ink width relative to what was expected there."""
LEAST_BLUR, BLUR_RANGE = 0.3, 3.0
"""px, the area of a pixel alone; factor by which the blur may differ from what was expected."""
FAINTEST_LIGHT = 1e-4
LEAST_FREEDOM = 0.1
"""Of a residual that a fit nearly forces to zero."""
GROUPS, CHI_MEDIAN = 12, 0.4549
"""Groups of brightness; median of chi-square with one degree of freedom."""
OUTLYING_SQUARE = 20.0
"""Squared residuals beyond this multiple of the variance tell of dirt, not of noise."""


@dataclass(frozen=True)
class Noise:
    """Variance of a pixel of brightness m: `additive` + `gain` m."""

    additive: float
    gain: float

    def variance(self, brightness: Array) -> Array:
        return np.maximum(self.additive + self.gain * brightness, FAINTEST_LIGHT**2)


@dataclass(frozen=True, eq=False)
class Bars:
    """Of every bin: paper `brightness`, `place` [px] and `width` [px] of the ink, `sigma` [px] of the place, `misfit`
    (chi-square per degree of freedom), each (b,). Of the line: `blur` [px], `contrast`, coefficients of the `slope`.
    Of every pixel: `predicted` brightness and `square` (n,) of its residual, corrected for the fitted parameters.
    """

    brightness: Array
    place: Array
    width: Array
    blur: float
    contrast: float
    slope: Array
    sigma: Array
    misfit: Array
    predicted: Array
    square: Array


@dataclass(frozen=True, eq=False)
class Start:
    """What is expected: ink `width` (b,) [px] of the bins, `blur` [px] and `contrast` of the line with the standard
    uncertainties `blur_sigma` [px] and `contrast_sigma`.
    """

    width: Array
    blur: float
    blur_sigma: float
    contrast: float
    contrast_sigma: float


def fit_bars(strip: Strip, along: Array, start: Start, noise: Noise) -> Bars:
    """All bins of a strip at once; the slope of the light is a combination of the columns of `along` (b, q)."""
    bins = strip.bins
    light = np.maximum(np.maximum.reduceat(strip.value, strip.starts), FAINTEST_LIGHT)
    own = np.stack([light, np.zeros_like(light), start.width], axis=1)
    centre = np.concatenate([[start.blur, start.contrast], np.zeros(along.shape[1])])
    prior = np.concatenate([
        [start.blur_sigma**-2, start.contrast_sigma**-2], np.full(along.shape[1], SLOPE_PRIOR**-2)
    ])  # fmt: skip
    shared = centre.copy()
    expected = np.maximum(start.width, NARROWEST)
    for _ in range(STEPS):
        predicted, slopes = _model(strip.across, own[bins], shared, (along @ shared[2:])[bins])
        variance = noise.variance(predicted)
        equations = _Equations.summed(slopes, 1 / variance, strip.value - predicted, strip, along)
        equations.expect(prior, centre - shared, (WIDTH_PRIOR * expected) ** -2, expected - own[:, 2])
        step, step_shared = equations.solved()
        step[:, 0] = np.clip(step[:, 0], -0.5 * own[:, 0], own[:, 0])
        step[:, 1:] = np.clip(step[:, 1:], -LONGEST_STEP, LONGEST_STEP)
        own, shared = own + step, shared + step_shared
        shared[0] = np.clip(shared[0], max(LEAST_BLUR, start.blur / BLUR_RANGE), BLUR_RANGE * start.blur)
        shared[1] = np.clip(shared[1], 0.02, 1.0)
        if np.abs(step[:, 1]).max() < SETTLED:
            break
    predicted, slopes = _model(strip.across, own[bins], shared, (along @ shared[2:])[bins])
    variance = noise.variance(predicted)
    followed = equations.leverage(slopes, bins) / variance
    square = (strip.value - predicted) ** 2 / np.maximum(1 - followed, LEAST_FREEDOM)
    counts = np.diff(np.append(strip.starts, strip.value.size))
    misfit = np.add.reduceat(square / variance, strip.starts) / counts
    return Bars(
        own[:, 0], own[:, 1], own[:, 2], float(shared[0]), float(shared[1]), shared[2:],
        equations.sigma(), misfit, predicted, square,
    )  # fmt: skip


def _model(across: Array, own: Array, shared: Array, slope: Array) -> tuple[Array, list[Array]]:
    """Brightness (n,), and its derivatives (n,) by brightness, place and width of the bin, by blur and contrast of the
    line, and by the slope of the light.
    """
    from scipy.special import ndtr

    brightness, place, width = own.T
    blur, contrast = shared[:2]
    left, right = (across - place + width / 2) / blur, (across - place - width / 2) / blur
    bar = ndtr(left) - ndtr(right)
    rise, fall = (np.exp(-0.5 * edge**2) / np.sqrt(2 * np.pi) for edge in (left, right))
    light, paper = 1 + slope * across, 1 - contrast * bar
    shade, dark = light * paper, brightness * light * contrast / blur
    by_line = [dark * (left * rise - right * fall), -brightness * light * bar, brightness * across * paper]
    return brightness * shade, [shade, dark * (rise - fall), -dark * (rise + fall) / 2, *by_line]


@dataclass(eq=False)
class _Equations:
    """Normal equations: blocks of the bins `normal` (b, 3, 3), of bins by line `mixed` (b, 3, q), of the line `common`
    (q, q), and the right-hand sides `right` (b, 3), `right_shared` (q,).
    """

    normal: Array
    mixed: Array
    common: Array
    right: Array
    right_shared: Array

    @classmethod
    def summed(cls, slopes: list[Array], weight: Array, residual: Array, strip: Strip, along: Array) -> "_Equations":
        count, size = strip.starts.size, len(slopes)
        block, right = np.empty((count, size, size)), np.empty((count, size))
        for row in range(size):
            weighted = slopes[row] * weight
            right[:, row] = np.add.reduceat(weighted * residual, strip.starts)
            for column in range(row, size):
                block[:, row, column] = np.add.reduceat(weighted * slopes[column], strip.starts)
                block[:, column, row] = block[:, row, column]
        mixed = np.concatenate([block[:, :3, 3:5], block[:, :3, 5:] * along[:, None, :]], axis=2)
        common = np.empty((2 + along.shape[1],) * 2)
        common[:2, :2] = block[:, 3:5, 3:5].sum(axis=0)
        common[:2, 2:] = block[:, 3:5, 5].T @ along
        common[2:, :2] = common[:2, 2:].T
        common[2:, 2:] = along.T @ (block[:, 5, 5][:, None] * along)
        right_shared = np.concatenate([right[:, 3:5].sum(axis=0), along.T @ right[:, 5]])
        return cls(block[:, :3, :3], mixed, common, right[:, :3], right_shared)

    def expect(self, weight_shared: Array, shared: Array, weight_width: Array, width: Array) -> None:
        """Add what was known before: how far the line's parameters and the widths are from it, and how surely."""
        self.common[np.diag_indices(len(shared))] += weight_shared
        self.right_shared += weight_shared * shared
        self.normal[:, 2, 2] += weight_width
        self.right[:, 2] += weight_width * width
        self.normal += 1e-12 * np.einsum("bii->bi", self.normal)[:, :, None] * np.eye(3)

    def solved(self) -> tuple[Array, Array]:
        """Steps of the bins (b, 3) and of the line (q,)."""
        self.inverse = np.linalg.inv(self.normal)
        self.carried = self.inverse @ self.mixed
        self.reduced = self.common - np.tensordot(self.mixed, self.carried, axes=([0, 1], [0, 1]))
        pull = self.right_shared - np.tensordot(self.carried, self.right, axes=([0, 1], [0, 1]))
        shared = np.linalg.solve(self.reduced, pull)
        shared[:2] = np.clip(shared[:2], -LONGEST_SHARED, LONGEST_SHARED)
        return np.einsum("bij,bj->bi", self.inverse, self.right) - self.carried @ shared, shared

    def leverage(self, slopes: list[Array], bins: Whole) -> Array:
        """Variance (n,) that the fit takes from each pixel's residual: a bin's few dark pixels decide its place."""
        own = np.stack(slopes[:3], axis=1)
        return np.einsum("ni,nij,nj->n", own, self.inverse[bins], own)

    def sigma(self) -> Array:
        """Standard uncertainty (b,) of the places."""
        carried = self.carried[:, 1]
        return np.sqrt(self.inverse[:, 1, 1] + np.einsum("bq,bq->b", carried @ np.linalg.inv(self.reduced), carried))


def learn_noise(lines: list[Bars]) -> Noise:
    """The noise that the residuals of all lines show, as a straight line over the brightness: first by the medians of
    equally many pixels of like brightness, which dirt does not move, then by all pixels but the outlying.
    """
    predicted = np.concatenate([line.predicted for line in lines])
    square = np.concatenate([line.square for line in lines])
    order = np.argsort(predicted)
    groups = np.array_split(order, min(GROUPS, max(2, predicted.size // 50)))
    level = np.array([predicted[group].mean() for group in groups])
    typical = np.array([np.median(square[group]) for group in groups]) / CHI_MEDIAN
    noise = _straight(level, typical, typical)
    for _ in range(3):
        variance = noise.variance(predicted)
        kept = square < OUTLYING_SQUARE * variance
        noise = _straight(predicted[kept], square[kept], variance[kept])
    return noise


def _straight(level: Array, square: Array, variance: Array) -> Noise:
    """The straight line through squared residuals whose own scatter is as their expected `variance`."""
    design = np.stack([np.ones(level.size), level], axis=1) / (variance + FAINTEST_LIGHT**2)[:, None]
    additive, gain = np.linalg.lstsq(design, square / (variance + FAINTEST_LIGHT**2), rcond=None)[0]
    if gain < 0:
        return Noise(float(np.mean(square)), 0.0)
    return Noise(float(additive), float(gain))

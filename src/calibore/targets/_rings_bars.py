"""The place of a dark line across a strip: a blurred bar of ink on paper, fitted to the pixels of each bin.

brightness(t) = b (1 + g t) (1 - c bar(t - t0; w, s)),  bar(x; w, s) = Phi((x + w/2) / s) - Phi((x - w/2) / s)

t [px] across the line. Each bin has its own paper brightness b, ink width w [px] and place t0 [px]; blur s [px], ink
contrast c and the slope of the light g(along the line) [1/px] belong to the whole line. t0 is the midpoint of the two
ink edges in the picture: symmetric errors of w, s, c do not move it, the slope of the light multiplies paper and ink.
"""

from dataclasses import dataclass, replace

import numpy as np

from calibore.targets._marks import Array
from calibore.targets._rings_strips import Strip

STEPS = 8
LONGEST_STEP = 0.5
"""px: of place and width in one step."""
BLUR_PRIOR, SLOPE_PRIOR = 0.5, 0.01
"""Relative standard uncertainty of the starting blur; standard uncertainty of the light's slope [1/px]."""
WIDTH_PRIOR = 0.5
"""Standard uncertainty of a bin's ink width relative to what was expected there."""
LEAST_BLUR = 0.3
"""px: the area of a pixel alone."""
FAINTEST_LIGHT = 1e-4


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
    Of every pixel: `predicted` and `residual` (n,).
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
    residual: Array


@dataclass(frozen=True, eq=False)
class Start:
    """What is expected: ink `width` (b,) [px] of the bins, `blur` [px] and `contrast` of the line with the standard
    uncertainty `contrast_sigma`.
    """

    width: Array
    blur: float
    contrast: float
    contrast_sigma: float


def fit_bars(strip: Strip, along: Array, start: Start, noise: Noise) -> Bars:
    """All bins of a strip at once; the slope of the light is a combination of the columns of `along` (n, q)."""
    bins = strip.bins
    light = np.maximum(np.maximum.reduceat(strip.value, strip.starts), FAINTEST_LIGHT)
    own = np.stack([light, np.zeros_like(light), start.width], axis=1)
    shared = np.concatenate([[start.blur, start.contrast], np.zeros(along.shape[1])])
    prior = np.concatenate([
        [(BLUR_PRIOR * start.blur) ** -2, start.contrast_sigma**-2], np.full(along.shape[1], SLOPE_PRIOR**-2)
    ])  # fmt: skip
    centre = shared.copy()
    expected = np.maximum(start.width, 0.1)
    for _ in range(STEPS):
        predicted, by_own, by_shared = _model(strip.across, along, own[bins], shared)
        weight = 1 / noise.variance(predicted)
        residual = strip.value - predicted
        normal, mixed, common, right, right_shared = _sums(strip, by_own, by_shared, weight, residual)
        normal[:, 2, 2] += (WIDTH_PRIOR * expected) ** -2
        right[:, 2] += (expected - own[:, 2]) * (WIDTH_PRIOR * expected) ** -2
        inverse = np.linalg.inv(normal + 1e-12 * np.einsum("bii->bi", normal)[:, :, None] * np.eye(3))
        reduced = common + np.diag(prior) - np.einsum("biq,bij,bjr->qr", mixed, inverse, mixed)
        pull = right_shared + prior * (centre - shared) - np.einsum("biq,bij,bj->q", mixed, inverse, right)
        step_shared = np.linalg.solve(reduced, pull)
        step = np.einsum("bij,bj->bi", inverse, right - mixed @ step_shared)
        step[:, 0] = np.clip(step[:, 0], -0.5 * own[:, 0], own[:, 0])
        step[:, 1:] = np.clip(step[:, 1:], -LONGEST_STEP, LONGEST_STEP)
        own, shared = own + step, shared + step_shared
        shared[0] = np.clip(shared[0], max(LEAST_BLUR, 0.5 * start.blur), 2 * start.blur)
        shared[1] = np.clip(shared[1], 0.02, 1.0)
    predicted, *_ = _model(strip.across, along, own[bins], shared)
    residual = strip.value - predicted
    variance = noise.variance(predicted)
    spread = inverse + np.einsum("bij,bjq,qr,bkr,bkl->bil", inverse, mixed, np.linalg.inv(reduced), mixed, inverse)
    counts = np.diff(np.append(strip.starts, strip.value.size))
    misfit = np.add.reduceat(residual**2 / variance, strip.starts) / np.maximum(counts - 3, 1)
    return Bars(
        own[:, 0], own[:, 1], own[:, 2], float(shared[0]), float(shared[1]), shared[2:],
        np.sqrt(spread[:, 1, 1]), misfit, predicted, residual,
    )  # fmt: skip


def _model(across: Array, along: Array, own: Array, shared: Array) -> tuple[Array, Array, Array]:
    """Brightness (n,) and its derivatives by each bin's (n, 3) and by the line's parameters (n, 2 + q)."""
    from scipy.special import ndtr

    brightness, place, width = own.T
    blur, contrast, slope = shared[0], shared[1], along @ shared[2:]
    left, right = (across - place + width / 2) / blur, (across - place - width / 2) / blur
    bar = ndtr(left) - ndtr(right)
    rise, fall = (np.exp(-0.5 * edge**2) / np.sqrt(2 * np.pi) for edge in (left, right))
    light, paper = 1 + slope * across, 1 - contrast * bar
    dark = brightness * light * contrast / blur
    by_own = np.stack([light * paper, dark * (rise - fall), -dark * (rise + fall) / 2], axis=1)
    by_slope = (brightness * across * paper)[:, None] * along
    by_line = np.stack([dark * (left * rise - right * fall), -brightness * light * bar], axis=1)
    return brightness * light * paper, by_own, np.concatenate([by_line, by_slope], axis=1)


def _sums(
    strip: Strip, by_own: Array, by_shared: Array, weight: Array, residual: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Blocks of the normal equations: bins (b, 3, 3), bins by line (b, 3, q), line (q, q), and right-hand sides."""
    weighted = by_own * weight[:, None]
    normal = np.add.reduceat(weighted[:, :, None] * by_own[:, None, :], strip.starts)
    mixed = np.add.reduceat(weighted[:, :, None] * by_shared[:, None, :], strip.starts)
    right = np.add.reduceat(weighted * residual[:, None], strip.starts)
    heavy = by_shared * weight[:, None]
    return normal, mixed, heavy.T @ by_shared, right, heavy.T @ residual


def learn_noise(lines: list[Bars], start: Noise) -> Noise:
    """The noise that the residuals of all lines show, as a straight line over the brightness."""
    predicted = np.concatenate([line.predicted for line in lines])
    square = np.concatenate([line.residual for line in lines]) ** 2
    noise = start
    for _ in range(5):
        variance = noise.variance(predicted)
        kept = square < 16 * variance
        design = np.stack([np.ones(int(kept.sum())), predicted[kept]], axis=1) / variance[kept, None]
        additive, gain = np.linalg.lstsq(design, square[kept] / variance[kept], rcond=None)[0]
        noise = replace(noise, additive=float(additive), gain=float(gain))
    return noise

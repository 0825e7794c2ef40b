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

from calibore.targets._rings_equations import Equations
from calibore.targets._rings_noise import Noise
from calibore.targets._rings_strips import Strip

Array = NDArray[Any]

STEPS, SETTLED = 12, 1e-4
"""At most so many Gauss-Newton steps, until no place moves by more [px]."""
LONGEST_STEP, NARROWEST = 0.5, 0.1
"""px: of place and width in one step; width below which expectations are equally unsure."""
SLOPE_PRIOR = 0.01
"""Standard uncertainty of the light's slope [1/px]."""
WIDTH_PRIOR = 0.5
"""Standard uncertainty of a bin's ink width relative to what was expected there."""
BLUR_STEP, CONTRAST_STEP = 0.3, 0.1
"""Of the blur, and of the contrast, in one step."""
LEAST_BLUR, BLUR_RANGE = 0.3, 5.0
"""px, the area of a pixel alone; factor by which the blur may differ from what was expected."""
FAINTEST_LIGHT, LEAST_CONTRAST = 1e-4, 0.02
LEAST_FREEDOM = 0.1
"""Of a residual that a fit nearly forces to zero."""


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
    fit = _Fit.begun(strip, along, start, noise)
    equations = fit.equations()
    for _ in range(STEPS):
        moved = fit.advance(*equations.solved(fit.longest))
        equations = fit.equations()
        if moved < SETTLED:
            break
    equations.solved(fit.longest)
    return fit.bars(equations)


@dataclass(eq=False)
class _Fit:
    """Where the fit stands: `own` (b, 3) brightness, place, width of the bins, `shared` (2 + q,) of the line."""

    strip: Strip
    along: Array
    start: Start
    noise: Noise
    own: Array
    shared: Array

    @classmethod
    def begun(cls, strip: Strip, along: Array, start: Start, noise: Noise) -> "_Fit":
        light = np.maximum(np.maximum.reduceat(strip.value, strip.starts), FAINTEST_LIGHT)
        own = np.stack([light, np.zeros_like(light), start.width], axis=1)
        shared = np.concatenate([[start.blur, start.contrast], np.zeros(along.shape[1])])
        return cls(strip, along, start, noise, own, shared)

    @property
    def longest(self) -> Array:
        """Longest steps of blur [px] and contrast."""
        return np.array([BLUR_STEP * self.shared[0], CONTRAST_STEP])

    def model(self) -> tuple[Array, list[Array]]:
        """Brightness (n,) of the pixels and its derivatives."""
        bins, slope = self.strip.bins, self.along @ self.shared[2:]
        return _model(self.strip.across, self.own[bins], self.shared, slope[bins])

    def equations(self) -> Equations:
        """What pixels and expectations say of the next step."""
        predicted, slopes = self.model()
        weight, residual = 1 / self.noise.variance(predicted), self.strip.value - predicted
        equations = Equations.summed(slopes, weight, residual, self.strip, self.along)
        start, slope = self.start, self.shared[2:]
        off = np.concatenate([[start.blur - self.shared[0], start.contrast - self.shared[1]], -slope])
        sure = [start.blur_sigma**-2, start.contrast_sigma**-2, *[SLOPE_PRIOR**-2] * slope.size]
        expected = np.maximum(start.width, NARROWEST)
        equations.expect(np.array(sure), off, (WIDTH_PRIOR * expected) ** -2, expected - self.own[:, 2])
        return equations

    def advance(self, step: Array, step_shared: Array) -> float:
        """Take a step, not too long; the farthest [px] that a place or, tenfold, the blur moved."""
        step[:, 0] = np.clip(step[:, 0], -0.5 * self.own[:, 0], self.own[:, 0])
        step[:, 1:] = np.clip(step[:, 1:], -LONGEST_STEP, LONGEST_STEP)
        self.own, self.shared = self.own + step, self.shared + step_shared
        blur = self.start.blur
        self.shared[0] = np.clip(self.shared[0], max(LEAST_BLUR, blur / BLUR_RANGE), BLUR_RANGE * blur)
        self.shared[1] = np.clip(self.shared[1], LEAST_CONTRAST, 1.0)
        return float(max(np.abs(step[:, 1]).max(), abs(step_shared[0]) / 10))

    def bars(self, equations: Equations) -> Bars:
        """The result; residuals are those that noise alone would leave without the fit."""
        predicted, slopes = self.model()
        variance = self.noise.variance(predicted)
        followed = equations.leverage(slopes, self.strip.bins) / variance
        square = (self.strip.value - predicted) ** 2 / np.maximum(1 - followed, LEAST_FREEDOM)
        counts = np.diff(np.append(self.strip.starts, self.strip.value.size))
        misfit = np.add.reduceat(square / variance, self.strip.starts) / counts
        (brightness, place, width), (blur, contrast) = self.own.T, self.shared[:2]
        return Bars(
            brightness, place, width, float(blur), float(contrast), self.shared[2:],
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

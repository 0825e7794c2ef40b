"""Steger's line detector, as `native/src/stripe/ridge.rs`: where the smoothed picture's slope across a line is zero.

About a candidate the picture is smoothed with a Gaussian of the line's own width. n, across the line, is the
eigenvector of its second derivatives H with the most negative eigenvalue b; the line runs through the pixel where t n
with t = -(g . n) / b, g the first derivatives, lies within it (C. Steger, "An unbiased detector of curvilinear
structures", IEEE TPAMI 20(2), 1998, section 3.2), and crosses the ray straight from there.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import ScanSettings
from calibore.stripe._noise import NoiseModel
from calibore.stripe._rays import Rays
from calibore.stripe._refine import LONGEST_STEP

Array = NDArray[np.float64]
NARROWEST, WIDEST = 1.0, 8.0
"""Limits of the smoothing [px]: below, samples of a Gaussian's slope are too few; above, windows too large."""
WITHIN = 0.6
"""A line point this near to its pixel's middle [px, in row and column] is that pixel's; half a pixel leaves gaps."""
MOST_PIXELS = 4
"""Pixels tried one after the other, each where the one before sees the line."""
LEAST_CROSSING = 0.25
"""Least cosine of the angle between ray and n: a line along the ray has no place on it."""


class Kernel(NamedTuple):
    """Samples (2 half + 1,) of a Gaussian of `sigma` [px], and what its first and second derivative weigh them by."""

    sigma: float
    smooth: Array
    slope: Array
    bend: Array

    @property
    def half(self) -> int:
        return self.smooth.size // 2

    @classmethod
    def of(cls, width: float) -> "Kernel":
        sigma = float(np.clip(width, NARROWEST, WIDEST))
        half = int(np.ceil(4 * sigma))
        x = np.arange(-half, half + 1, dtype=np.float64)
        smooth = np.exp(-(x**2) / (2 * sigma**2))
        smooth /= np.sum(smooth)
        return cls(sigma, smooth, x / sigma**2 * smooth, (x**2 / sigma**4 - 1 / sigma**2) * smooth)


def ridges(
    plane: NDArray[np.generic], rays: Rays, position: Array, height: Array, settings: ScanSettings
) -> tuple[Array, Array]:
    """`position` (n,) [px] of peaks of `height` (n,) along `rays` by Steger's detector, and its u (n,) [px].

    NaN where there is no line about a peak: too near to the edge of `plane` (h, w), no ridge, or one along the ray.
    """
    kernel = Kernel.of(settings.noise.width)
    place, u = np.full(rays.count, np.nan), np.full(rays.count, np.nan)
    left = np.flatnonzero(np.isfinite(position))
    pixel = _nearest(np.stack(rays.at(position), axis=1)[left])
    for _ in range(MOST_PIXELS):
        inside = np.all((pixel >= kernel.half) & (pixel < np.array(plane.shape[::-1]) - kernel.half), axis=1)
        left, pixel = left[inside], pixel[inside]
        bend, across, point = _line_points(plane, pixel, kernel)
        with np.errstate(invalid="ignore"):
            own = np.all(np.abs(point - pixel) <= WITHIN, axis=1)
        crossing = np.sum(across * rays.direction[left], axis=1)
        start = np.stack(rays.at(position), axis=1)[left]
        step = np.sum(across * (point - start), axis=1) / np.where(crossing == 0, 1.0, crossing)
        good = own & (np.abs(crossing) >= LEAST_CROSSING) & (np.abs(step) <= LONGEST_STEP)
        place[left[good]] = (position[left] + step)[good]
        moved = _moved(height[left], settings.noise, kernel) / np.abs(bend * np.where(good, crossing, 1.0))
        u[left[good]] = moved[good]
        follow = ~own & (np.max(np.abs(point - start), axis=1) <= 2 * LONGEST_STEP)
        left, pixel = left[follow], _nearest(point[follow])
    return place, u


def _nearest(point: Array) -> NDArray[np.intp]:
    return np.floor(point + 0.5).astype(np.intp)


def _line_points(plane: NDArray[np.generic], pixel: NDArray[np.intp], kernel: Kernel) -> tuple[Array, Array, Array]:
    """Second derivative across the line (m,), unit n (m, 2) and the line's point (m, 2) as seen from `pixel` (m, 2);
    points are infinite where there is no ridge.
    """
    reach = np.arange(-kernel.half, kernel.half + 1)
    window = plane[pixel[:, 1, None, None] + reach[:, None], pixel[:, 0, None, None] + reach].astype(np.float64)
    by_column = [window @ weights for weights in (kernel.smooth, kernel.slope, kernel.bend)]
    (s, p, q), (smooth, slope, bend) = by_column, kernel[1:]
    du, dv, uu, vv, uv = p @ smooth, s @ slope, q @ smooth, s @ bend, p @ slope
    least = 0.5 * (uu + vv) - np.sqrt(0.25 * (uu - vv) ** 2 + uv**2)
    across = np.where((uu < vv)[:, None], np.stack([least - vv, uv], axis=1), np.stack([uv, least - uu], axis=1))
    length = np.hypot(across[:, 0], across[:, 1])
    ridge = (least < 0) & (length > 0)
    across = across / np.where(ridge, length, 1.0)[:, None]
    t = -(du * across[:, 0] + dv * across[:, 1]) / np.where(ridge, least, 1.0)
    return least, across, np.where(ridge[:, None], pixel + t[:, None] * across, np.inf)


def _moved(height: Array, noise: NoiseModel, kernel: Kernel) -> Array:
    """Standard deviation (n,) of the slope across a straight line of `height` (n,) under pixel noise and speckle.

    Integrals of the squared weights of the slope, n G(n) G(t) / sigma^2, times the line's brightness
    h exp(-n^2 / 2 width^2) and its square, in closed form; speckle is correlated by exp(-n^2 / 4 grain^2) across the
    line and exp(-t^2 / 4 blur^2) along it, 1 / blur^2 = 1 / grain^2 + 1 / width^2.
    """
    sigma, width, grain = kernel.sigma, noise.width, noise.grain
    white = 1 / (8 * np.pi * sigma**4)
    lit = 1 / (8 * np.pi * sigma**7) / (1 / sigma**2 + 1 / (2 * width**2)) ** 1.5
    narrow = 1 / sigma**2 + 1 / width**2
    speckled = 1 / (2 * grain**2 * sigma**6) / (narrow**2 + narrow / grain**2) ** 1.5
    along = 1 + sigma**2 * (1 / grain**2 + 1 / width**2)
    contrast = noise.contrast * height**2 * speckled / np.sqrt(along)
    return np.sqrt(noise.additive * white + noise.gain * height * lit + contrast)

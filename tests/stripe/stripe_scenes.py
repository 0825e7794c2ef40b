"""Images of laser lines whose place is known."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
READ, GAIN = 1.0, 0.04
"""Standard deviation of read noise [grey values] and variance of shot noise per grey value."""
BACKGROUND = 8.0


def exposed(brightness: Array, rng: np.random.Generator, *, white: int = 255) -> NDArray[np.generic]:
    """`brightness` in grey values of 0 .. 255 with shot and read noise, rounded and clipped by the camera."""
    noisy = brightness + rng.normal(size=brightness.shape) * np.sqrt(READ**2 + GAIN * brightness)
    whole = np.clip(np.rint(noisy * (white / 255)), 0, white)
    return whole.astype(np.uint8 if white == 255 else np.uint16)


def line_image(
    rng: np.random.Generator, *, columns: int = 3000, width: float = 2.0, peak: float = 175.0, slope: float = 0.0173
) -> tuple[NDArray[np.generic], Array]:
    """(image, true row per column) of a straight Gaussian line, sampled at every phase between pixels."""
    row = 30.37 + slope * np.arange(columns)
    distance = np.arange(row.max() + 30)[:, None] - row
    return exposed(BACKGROUND + peak * np.exp(-(distance**2) / (2 * width**2)), rng), row


def speckled_line(
    rng: np.random.Generator, contrast: float, *, columns: int = 3000, width: float = 2.0, blur: float = 1.2
) -> tuple[NDArray[np.generic], Array]:
    """The same with speckle of `contrast` (standard deviation over mean) that the optics have blurred [px]."""
    row = 30.37 + 0.0173 * np.arange(columns)
    distance = np.arange(row.max() + 30)[:, None] - row
    sharp = np.exp(-(distance**2) / (2 * (width**2 - blur**2)))
    grains = 1 / (contrast**2 * 4 * np.pi * blur**2)
    blurred = gaussian_filter(sharp * rng.gamma(grains, 1 / grains, size=sharp.shape), blur)
    return exposed(BACKGROUND + 90.0 * width / np.sqrt(width**2 - blur**2) * blurred, rng), row


def ring_brightness(shape: tuple[int, int], centre: tuple[float, float], radius: float, *, width: float = 1.6) -> Array:
    """Brightness 0 .. 1 of a ring of Gaussian section in an image of `shape` (h, w)."""
    row, column = np.indices(shape)
    return np.exp(-((np.hypot(column - centre[0], row - centre[1]) - radius) ** 2) / (2 * width**2))


def red(brightness: Array, rng: np.random.Generator) -> NDArray[np.generic]:
    """(h, w, 3) image of red light of `brightness` [grey values]: a fifth of it leaks into the other colours."""
    return np.stack([exposed(BACKGROUND + share * brightness, rng) for share in (1.0, 0.2, 0.15)], axis=2)


def cramer_rao(row: Array, *, width: float, peak: float) -> float:
    """Least rms error [px] of the row of a Gaussian line of unknown height and background, sampled at whole rows."""
    x = np.arange(-15, 16) - (row - np.rint(row))[:, None]
    shape = np.exp(-(x**2) / (2 * width**2))
    jacobian = np.stack([shape, peak * shape * x / width**2, np.ones_like(x)], axis=1)
    variance = READ**2 + GAIN * (BACKGROUND + peak * shape) + 1 / 12
    information = np.einsum("nam,nbm->nab", jacobian / variance[:, None], jacobian)
    return float(np.sqrt(np.mean(np.linalg.inv(information)[:, 1, 1])))

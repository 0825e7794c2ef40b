"""The reference peer: OpenCV unwraps the annulus, vectorised NumPy fits a parabola to every window of 8 samples.

Written as a careful user would: one remap, no Python loop over rays, re-centred on the area centroid to 0.5 px.
"""

import cv2
import numpy as np

RAYS = 1500
WINDOW = 8
THRESHOLD = 45.0

_LEVER = np.arange(WINDOW) - (WINDOW - 1) / 2
_SLOPE = (_LEVER / np.sum(_LEVER**2)).astype(np.float32)
_SQUARE = _LEVER**2 - np.mean(_LEVER**2)
_BEND = (_SQUARE / np.sum(_SQUARE**2)).astype(np.float32)


def unwrap(plane: np.ndarray, centre: tuple[float, float], inner: float, outer: float) -> np.ndarray:
    """(rays, samples) float32, one pixel apart from `inner` to `outer`."""
    samples = int(np.ceil(outer))
    flags = cv2.WARP_POLAR_LINEAR | cv2.INTER_LINEAR
    polar = cv2.warpPolar(plane, (samples, RAYS), centre, samples, flags)
    return polar[:, int(inner) :].astype(np.float32)


def parabola_peaks(annulus: np.ndarray) -> np.ndarray:
    """Place of the highest parabola vertex on each ray [samples], NaN where none reaches the threshold."""
    slope = cv2.filter2D(annulus, cv2.CV_32F, _SLOPE[None, :], anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    rows = np.arange(len(annulus))
    valid = annulus.shape[1] - WINDOW
    turns = (slope[:, :valid] > 0) & (slope[:, 1 : valid + 1] <= 0)
    bright = annulus[:, WINDOW // 2 : WINDOW // 2 + valid]
    first = np.argmax(np.where(turns, bright, -1.0), axis=1)
    windows = annulus[rows[:, None], first[:, None] + np.arange(WINDOW)]
    bend = windows @ _BEND
    offset = -slope[rows, first] / (2 * np.where(bend < 0, bend, np.nan))
    height = windows.mean(axis=1) + slope[rows, first] * offset + bend * (offset**2 - np.mean(_LEVER**2))
    return np.where(height > THRESHOLD, first + _LEVER[-1] + offset, np.nan)


def gravity_peaks(annulus: np.ndarray) -> np.ndarray:
    """Centre of gravity of 11 samples about the brightest one [samples]; a stronger peer."""
    rows = np.arange(len(annulus))
    brightest = np.clip(np.argmax(annulus, axis=1), 5, annulus.shape[1] - 6)
    index = brightest[:, None] + np.arange(-5, 6)
    window = annulus[rows[:, None], index]
    window = window - np.minimum(window[:, :1], window[:, -1:])
    return np.where(annulus[rows, brightest] > THRESHOLD, np.sum(window * index, axis=1) / window.sum(axis=1), np.nan)


def centroid(u: np.ndarray, v: np.ndarray) -> tuple[float, float]:
    """Area centroid of the polygon (Green's theorem)."""
    x, y = u - u.mean(), v - v.mean()
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = 3 * cross.sum()
    return (
        float(u.mean() + np.sum((x + np.roll(x, -1)) * cross) / area),
        float(v.mean() + np.sum((y + np.roll(y, -1)) * cross) / area),
    )


def ring(
    image: np.ndarray,
    centre: tuple[float, float],
    inner: float,
    outer: float,
    band: int,
    peaks=parabola_peaks,
    most: int = 8,
    unwrapping=unwrap,
):
    """(u, v) of the ring, NaN where not found; `image` (h, w, 3), unwrapped `most` times at most: once is enough for
    who starts from the centre of the picture before.
    """
    plane = np.ascontiguousarray(image[:, :, band])
    azimuth = np.arange(RAYS) * (2 * np.pi / RAYS)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    for _ in range(most):
        radius = int(inner) + peaks(unwrapping(plane, centre, inner, outer))
        u, v = centre[0] + radius * cos, centre[1] + radius * sin
        found = np.isfinite(u)
        moved = centroid(u[found], v[found])
        shift = np.hypot(moved[0] - centre[0], moved[1] - centre[1])
        if shift < 0.5:
            break
        centre = moved
    return u, v

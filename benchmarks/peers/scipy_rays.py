"""Plain SciPy: `map_coordinates` along the rays, `find_peaks` on each of them, a parabola through three samples."""

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.signal import find_peaks

from benchmarks.peers.opencv_warp_polar import RAYS, THRESHOLD

NEIGHBOURS = np.array([-1, 0, 1])
BLUR = np.array([1, 2, 3, 2, 1]) / 9


def unwrap(plane: np.ndarray, centre: tuple[float, float], inner: float, outer: float) -> np.ndarray:
    """(rays, samples) float32, one pixel apart from `inner` to `outer`, bilinear."""
    azimuth, radius = np.arange(RAYS) * (2 * np.pi / RAYS), np.arange(int(inner), int(np.ceil(outer)))
    columns = centre[0] + np.outer(np.cos(azimuth), radius)
    rows = centre[1] + np.outer(np.sin(azimuth), radius)
    return map_coordinates(plane, [rows, columns], output=np.float32, order=1, mode="nearest")


def peaks(annulus: np.ndarray) -> np.ndarray:
    """Place of the highest peak of every row [samples], NaN for none."""
    return np.array([_highest(np.convolve(row, BLUR, mode="same")) for row in annulus])


def _highest(row: np.ndarray) -> float:
    found, _ = find_peaks(row, height=THRESHOLD)
    if found.size == 0:
        return np.nan
    at = int(found[np.argmax(row[found])])
    before, here, after = row[at + NEIGHBOURS]
    return at + 0.5 * (before - after) / (before - 2 * here + after)

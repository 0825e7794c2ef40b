"""The script a user would write: OpenCV imread, the reference peer, the sine law, 400 clock positions."""

from pathlib import Path

import cv2
import numpy as np

from benchmarks.peers.opencv_warp_polar import ring

K, BASELINE, CENTRE = 571.0, 13.1, (512.0, 384.0)
INNER, OUTER = 120, 320
POSITIONS = 400


def profile(paths: list[Path]) -> dict[Path, np.ndarray]:
    """Radius [in] at 400 clock positions per image, NaN where nothing was found; no uncertainty."""
    return {path: radii(cv2.imread(str(path))) for path in paths}


def profile_raw(paths: list[Path]) -> dict[Path, np.ndarray]:
    """The same of PPM files of known size, whose pixels are their last bytes."""
    return {path: radii(raw(path), red=0) for path in paths}


def raw(path: Path, shape: tuple[int, int, int] = (768, 1024, 3)) -> np.ndarray:
    """The pixels as they lie in the file."""
    count = int(np.prod(shape))
    return np.fromfile(path, np.uint8, count, offset=path.stat().st_size - count).reshape(shape)


def radii(image: np.ndarray, red: int = 2) -> np.ndarray:
    """Radius [in] at 400 clock positions of one BGR image, or one whose `red` band is another."""
    u, v = ring(image, CENTRE, INNER, OUTER, band=red)
    x, y = u - CENTRE[0], v - CENTRE[1]
    radius = BASELINE * np.tan(np.arcsin(np.hypot(x, y) / K))
    position = np.rint(np.arctan2(x, -y) / (2 * np.pi) * POSITIONS)
    found = np.isfinite(radius)
    position = position[found].astype(int) % POSITIONS
    count = np.bincount(position, minlength=POSITIONS)
    total = np.bincount(position, weights=radius[found], minlength=POSITIONS)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)

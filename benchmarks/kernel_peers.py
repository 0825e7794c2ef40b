"""The kernels against other ways to do the same: SciPy, scikit-image, Numba, Steger; truth checked in the same run."""

import importlib.util
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np

from benchmarks import kernel, side_facing
from benchmarks.peers import opencv_warp_polar as opencv
from benchmarks.peers import side_rows, steger
from benchmarks.surveys import one_image
from benchmarks.timing import compare
from calibore.images import read_image
from calibore.stripe import detect_line, detect_ring

Contestants = dict[str, Callable[[], Any]]
CLOCK = time.process_time
"""Everything here has one thread; other jobs of the machine disturb this clock least."""
HEAD = ["| contestant | median ms | peer / contestant (95 %) |", "|---|---|---|"]


def rings(rounds: int | str = 40) -> list[str]:
    """Markdown lines: one picture to a ring of 1500 rays."""
    cv2.setNumThreads(1)
    one = one_image()
    search = (one.image, kernel.CENTRE, kernel.INNER, kernel.OUTER, 0)
    contestants: Contestants = {
        f"calibore, kernel {name}": partial(_ring, one.image, name) for name in ("native", "scalar")
    }
    contestants[kernel.REFERENCE] = partial(opencv.ring, *search)
    contestants["OpenCV warpPolar + centre of gravity"] = partial(opencv.ring, *search, opencv.gravity_peaks)
    contestants["Steger's detector by OpenCV filters + NumPy, not re-centred"] = partial(steger.ring, *search)
    contestants |= _with_packages(search)
    with np.errstate(all="ignore"):
        result = compare(
            contestants, peer=kernel.REFERENCE, rounds=int(rounds), rng=np.random.default_rng(3), clock=CLOCK
        )
        truth = {name: one.error(*call()) for name, call in contestants.items()}
    title = "## Kernel beside other ways: 1024 x 768 RGB, 1500 rays x 200 samples, one thread"
    return [title, *_absent(), *HEAD, *result.rows(), "", *_table("rays", truth)]


def rows(rounds: int | str = 40) -> list[str]:
    """Markdown lines: one picture of a side-facing head to a column per row."""
    cv2.setNumThreads(1)
    picture = read_image(side_facing.SIDE / f"side 000 {side_facing.STOP:03d} 0.png")
    image = np.ascontiguousarray(np.concatenate([picture, picture])[: side_facing.ROWS])
    contestants: Contestants = {
        f"calibore, kernel {name}": partial(_line, image, name) for name in ("native", "scalar")
    }
    contestants[side_facing.REFERENCE] = partial(side_rows.parabola, image, 0)
    contestants["OpenCV blur, argmax + centre of gravity"] = partial(side_rows.gravity, image, 0)
    contestants["Steger's detector by OpenCV filters + NumPy"] = partial(steger.line, image, 0)
    if _there("numba"):
        from benchmarks.peers import numba_rays

        contestants["Numba, parabola in one loop"] = partial(numba_rays.line, image, 0)
    with np.errstate(all="ignore"):
        result = compare(
            contestants, peer=side_facing.REFERENCE, rounds=int(rounds), rng=np.random.default_rng(4), clock=CLOCK
        )
        truth = dict(side_facing._truth(contestants))
    title = f"## Side-facing beside other ways: 1024 x {side_facing.ROWS} RGB, one peak per row, one thread"
    return [title, *_absent(), *HEAD, *result.rows(), "", *_table("rows", truth)]


def _ring(image: np.ndarray, how: str) -> tuple[np.ndarray, np.ndarray]:
    found = detect_ring(image, kernel.CENTRE, inner=kernel.INNER, outer=kernel.OUTER, channel="red", kernel=how)
    return found.u, found.v


def _line(image: np.ndarray, how: str) -> np.ndarray:
    return detect_line(image, down=True, channel="red", kernel=how).u


def _with_packages(search: tuple[Any, ...]) -> Contestants:
    """Peers whose packages are here."""
    from benchmarks.peers import scipy_rays

    found: Contestants = {"SciPy map_coordinates + find_peaks": _unwrapped(search, scipy_rays.peaks, scipy_rays.unwrap)}
    if _there("skimage"):
        from benchmarks.peers import skimage_polar

        name = "scikit-image warp_polar + NumPy parabola"
        found[name] = _unwrapped(search, opencv.parabola_peaks, skimage_polar.unwrap)
    if _there("numba"):
        from benchmarks.peers import numba_rays

        found["Numba, rays and parabola in one loop"] = partial(numba_rays.ring, *search)
    return found


def _unwrapped(search: tuple[Any, ...], peaks: Callable[..., Any], unwrap: Callable[..., Any]) -> Callable[[], Any]:
    return partial(opencv.ring, *search, peaks, unwrapping=unwrap)


def _there(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def _absent() -> list[str]:
    missing = [name for name in ("skimage", "numba") if not _there(name)]
    said = f"**{' and '.join(missing)} not installed: peers missing below.** `pip install -e .[peers]` brings them."
    return [said, ""] if missing else []


def _table(what: str, truth: dict[str, tuple[float, float]]) -> list[str]:
    rows = [f"| {name} | {rms:.3f} | {100 * share:.1f} |" for name, (rms, share) in truth.items()]
    return [f"| contestant | rms error px | {what} measured % |", "|---|---|---|", *rows]

"""A peer that measured badly would flatter us: each finds a clean ring and a clean line."""

import importlib.util
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2]))  # the package `benchmarks` stands beside `tests`

from benchmarks.__main__ import PARTS
from benchmarks.machine import machine
from benchmarks.peers import opencv_warp_polar as opencv
from benchmarks.peers import scipy_rays, side_rows, steger
from benchmarks.timing import compare

CENTRE, RADIUS, WIDTH = (251.3, 248.6), 200.25, 2.0
FOUND, LOCKED = 0.05, 0.2
"""px; a parabola through 8 samples of this line locks to them: -0.145 px at this radius, whatever unwraps the ring."""


def picture() -> np.ndarray:
    v, u = np.mgrid[:500, :500]
    light = 180 * np.exp(-((np.hypot(u - CENTRE[0], v - CENTRE[1]) - RADIUS) ** 2) / (2 * WIDTH**2)) + 10
    return np.repeat(np.rint(light).astype(np.uint8)[..., None], 3, axis=2)


def peer(module: str) -> Callable[..., object]:
    """A peer's module; its test is skipped where its package is absent."""
    package = {"skimage_polar": "skimage", "numba_rays": "numba"}[module]
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: pip install -e .[peers]")
    return import_module(f"benchmarks.peers.{module}")


def by_scipy(*search):
    return opencv.ring(*search, scipy_rays.peaks, unwrapping=scipy_rays.unwrap)


def by_skimage(*search):
    return opencv.ring(*search, unwrapping=peer("skimage_polar").unwrap)


def by_numba(*search):
    return peer("numba_rays").ring(*search)


RINGS = {by_scipy: FOUND, steger.ring: FOUND, opencv.ring: LOCKED, by_skimage: LOCKED, by_numba: LOCKED}


@pytest.mark.parametrize("ring", RINGS, ids=lambda ring: f"{ring.__module__}.{ring.__name__}")
def test_every_peer_finds_a_clean_ring(ring):
    with np.errstate(all="ignore"):
        u, v = ring(picture(), CENTRE, 150, 240, 0)
    found = np.hypot(u - CENTRE[0], v - CENTRE[1])
    assert np.isfinite(found).mean() > 0.99
    assert np.sqrt(np.nanmean((found - RADIUS) ** 2)) < RINGS[ring]


@pytest.mark.parametrize("name", ["parabola", "gravity", "steger", "numba"])
def test_every_peer_finds_a_clean_line(name):
    line = {"parabola": side_rows.parabola, "gravity": side_rows.gravity, "steger": steger.line}.get(name)
    row, column = np.mgrid[:80, :200]
    true = 100.3 + 0.1 * row[:, 0]
    light = 180 * np.exp(-((column - true[:, None]) ** 2) / (2 * WIDTH**2)) + 5
    image = np.repeat(np.rint(light).astype(np.uint8)[..., None], 3, axis=2)
    with np.errstate(all="ignore"):
        found = (line or peer("numba_rays").line)(image, 0)
    inner = slice(5, -5)  # filters look beyond the picture
    assert np.abs(found[inner] - true[inner]).max() < LOCKED


def test_a_line_as_dark_as_its_background_is_found_by_no_peer():
    flat = np.full((240, 240, 3), 12, np.uint8)
    assert steger.points(flat[:, :, 0])[0].size == 0
    assert np.isnan(scipy_rays.peaks(np.full((4, 60), 12.0, np.float32))).all()


def test_a_contestant_that_takes_twice_the_time_is_told_so_and_the_control_is_about_one():
    spent = {"now": 0.0}

    def spend(seconds: float) -> Callable[[], None]:
        return lambda: spent.update(now=spent["now"] + seconds)

    found = compare(
        {"peer": spend(2.0), "ours": spend(1.0)},
        peer="peer",
        rounds=20,
        rng=np.random.default_rng(1),
        clock=lambda: spent["now"],
    )
    assert found.ratio["ours"] == (2.0, 2.0, 2.0)
    assert found.ratio["peer (control)"] == (1.0, 1.0, 1.0)
    assert found.milliseconds["ours"] == 1000.0


@pytest.mark.parametrize("name", PARTS)
def test_every_table_has_a_function_that_makes_it(name):
    module, function = PARTS[name].function.split(".")
    source = (Path(__file__).parents[2] / "benchmarks" / f"{module}.py").read_text(encoding="utf-8")
    assert f"\ndef {function}(" in source


def test_the_machine_is_told_with_the_versions_of_what_is_timed():
    said = "\n".join(machine())
    for word in ("processor", "caches", "governor", f"numpy {np.__version__}", "opencv-python-headless 5"):
        assert word in said

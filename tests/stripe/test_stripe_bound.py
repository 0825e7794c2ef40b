"""The default estimator against the Cramer-Rao bound, in pictures whose truth is known."""

import sys
from pathlib import Path

import numpy as np
import pytest

from calibore.stripe import detect_line

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.estimator import COLUMNS, UNSEEN, Scene, score, unseen, with_speckle, without_speckle

NOISE_OF_RATIO = 0.02
"""Standard deviation of an rms of 3000 rays, of which every third is independent, over itself."""
BROKEN = "width 3.0, contrast 0.5, grain 0.7"
"""A line much wider than its strong speckle has no single peak on a ray: 1.34 times the bound instead of 1.25."""


@pytest.mark.parametrize("name", sorted(without_speckle()))
def test_without_speckle_a_place_is_as_good_as_its_pixels_allow(name: str) -> None:
    scene = without_speckle()[name]
    got = score(scene, "zero-crossing", 2)
    assert got.rms <= (1.10 + NOISE_OF_RATIO) * scene.bound()
    assert 0.9 <= got.ratio <= 1.1
    assert got.locking < 0.005
    assert got.lost == 0


@pytest.mark.parametrize("name", sorted(with_speckle()))
def test_with_speckle_that_nobody_told_it_of_a_place_is_nearly_as_good(name: str) -> None:
    scene = with_speckle()[name]
    got = score(scene, "zero-crossing", 2)
    assert got.rms <= (1.4 if name == BROKEN else 1.25) * scene.bound()
    assert 0.9 <= got.ratio <= 1.1 + 2 * NOISE_OF_RATIO
    assert got.rms < 0.95 * score(scene, "centroid", 2).rms


def test_so_it_is_in_random_scenes_on_which_nothing_was_tuned() -> None:
    for scene in unseen(12):
        got = score(scene, "zero-crossing", 2, first=UNSEEN)
        assert got.rms <= (1.25 if scene.contrast else 1.10 + NOISE_OF_RATIO) * scene.bound()
        assert 0.8 <= got.ratio <= 1.1


@pytest.mark.parametrize(("contrast", "least"), [(0.02, 0.99), (0.45, 0.92)])
@pytest.mark.parametrize("length", [12, 20, 40])
def test_neighbours_choose_the_standpoint_and_not_the_place(contrast: float, least: float, length: int) -> None:
    """A wall that waves within the reach of a ray's neighbours is measured with its waves."""
    scene, wave = Scene(1.3, 120.0, contrast, 0.9), 0.4 * np.sin(2 * np.pi * np.arange(COLUMNS) / length)
    gains = []
    for seed in range(3):
        picture, row = scene.draw(seed, wave=wave)
        stray = detect_line(picture).v - row + wave
        known = np.isfinite(stray)
        gains.append(float(stray[known] @ wave[known] / (wave[known] @ wave[known])))
    assert least <= np.mean(gains) <= 1.05


@pytest.mark.parametrize("contrast", [0.0, 0.1, 0.25])
def test_a_skewed_line_is_seen_near_its_top(contrast: float) -> None:
    """Weights that trust faint flanks would see it 0.36 px beside the place where its two sides meet; the fit of every
    peak alone, with weights for speckle, sees it 0.30 px beside.
    """
    got = score(Scene(1.5, 150.0, contrast, skew=0.1), "zero-crossing", 2)
    assert abs(got.bias) <= 0.31


@pytest.mark.parametrize("kernel", ["native", "numpy"])
def test_a_line_so_bright_that_it_is_clipped_everywhere_still_has_places(kernel: str) -> None:
    picture, row = Scene(2.0, 400.0).draw(1)
    stripe = detect_line(picture, kernel=kernel)
    assert np.isfinite(stripe.v).all()
    assert np.sqrt(np.mean((stripe.v - row) ** 2)) <= 1.3 * np.sqrt(np.mean(stripe.u_position**2)) <= 0.13

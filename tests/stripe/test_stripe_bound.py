"""The default estimator against the Cramer-Rao bound, in pictures whose truth is known."""

import itertools
import sys
from pathlib import Path

import numpy as np
import pytest

from calibore.simulation import speckle_field
from calibore.status import Status
from calibore.stripe import detect_line, detect_ring

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.clipped import CEILING, clipped_bound, clipped_scenes
from benchmarks.estimator import COLUMNS, SENSOR, UNSEEN, Scene, score, unseen, with_speckle, without_speckle

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


CLIPPED = [
    *(
        f"width {width}, contrast {contrast}, peak {peak}"
        for width in (1.5, 2.0, 3.0)
        for contrast in (0.0, 0.1, 0.3)
        for peak in (260, 400, 1000)
    ),
    "16 bits, peak 400",
]


@pytest.mark.parametrize("name", CLIPPED)
def test_a_clipped_line_is_placed_as_well_as_what_is_left_of_it_allows(name: str) -> None:
    scene = clipped_scenes()[name]
    got = score(scene, "zero-crossing", 2)
    assert got.rms <= (1.25 + NOISE_OF_RATIO) * clipped_bound(scene)
    assert 0.9 <= got.ratio <= 1.1
    assert got.locking < (0.01 if scene.contrast < 0.3 else 0.02), "speckle of 0.3 has waves of 0.01 px of its own"
    assert got.lost < 0.001


def test_the_bound_of_a_clipped_line_lies_between_those_of_all_its_samples_and_of_the_unclipped_ones() -> None:
    for scene in (Scene(2.0, 400.0), Scene(2.0, 400.0, 0.1), Scene(1.5, 1000.0, 0.3)):
        without = []
        for phase in np.linspace(-0.5, 0.5, 8, endpoint=False):
            mean, covariance, jacobian = scene.model(phase)
            seen = mean < CEILING
            weighted = np.linalg.solve(covariance[np.ix_(seen, seen)], jacobian[seen])
            without.append(np.linalg.inv(jacobian[seen].T @ weighted)[0, 0])
        assert scene.bound() < clipped_bound(scene) < 1.01 * np.sqrt(np.mean(without))
    assert clipped_bound(Scene(2.0, 200.0, 0.05)) == pytest.approx(Scene(2.0, 200.0, 0.05).bound(), rel=1e-3)


def clipped_ring(peak: float, contrast: float, *, dim: float = 1.0, seed: int = 0) -> tuple[np.ndarray, float, tuple]:
    """(picture, radius, centre) of a ring 2 px wide, `peak` on one side and `dim` of that on the other."""
    rng = np.random.default_rng([seed, 9])
    centre, radius = (150.3, 149.8), 100.37 + rng.uniform(-0.5, 0.5)
    row, column = np.indices((300, 300))
    x, y = column - centre[0], row - centre[1]
    light = peak * dim ** (0.5 - 0.5 * x / np.hypot(x, y)) / 255 * np.exp(-((np.hypot(x, y) - radius) ** 2) / 8)
    field = speckle_field(light.shape, contrast=contrast, grain=2.0, rng=rng)
    return SENSOR.read_out((light * field)[:, :, None], rng)[:, :, 0], radius, centre


@pytest.mark.parametrize(("peak", "contrast", "dim"), [(400.0, 0.0, 1.0), (1000.0, 0.0, 1.0), (400.0, 0.2, 1.0)])
def test_so_it_is_round_a_ring_whose_samples_lie_between_pixels(peak: float, contrast: float, dim: float) -> None:
    errors, u = [], []
    for seed in range(3):
        picture, radius, (x, y) = clipped_ring(peak, contrast, dim=dim, seed=seed)
        stripe = detect_ring(picture, (150.0, 150.0), inner=60, outer=140, rays=600, channel="luma")
        errors.append(np.hypot(stripe.u - x, stripe.v - y) - radius)
        u.append(stripe.u_position)
    rms, doubt = (float(np.sqrt(np.mean(np.square(a)))) for a in (errors, u))
    assert rms <= 1.25 * clipped_bound(Scene(2.0, peak, contrast))
    assert 0.9 <= rms / doubt <= 1.1


@pytest.mark.parametrize("contrast", [0.0, 0.2])
def test_nothing_jumps_where_a_line_grows_brighter_than_its_picture_can_show(contrast: float) -> None:
    """From 130 on one side of a ring to 520 on the other; a sixth of the rays in each bin."""
    errors, u, side = [], [], []
    for seed in range(6):
        picture, radius, (x, y) = clipped_ring(520.0, contrast, dim=0.25, seed=seed)
        stripe = detect_ring(picture, (150.0, 150.0), inner=60, outer=140, rays=600, channel="luma")
        errors.append(np.hypot(stripe.u - x, stripe.v - y) - radius)
        u.append(stripe.u_position)
        side.append((stripe.u - x) / radius)
    error, doubt, where = (np.concatenate(a) for a in (errors, u, side))
    assert np.isfinite(error).all()
    edges = np.quantile(where, np.linspace(0, 1, 7))
    for low, high in itertools.pairwise(edges):
        some = (where >= low) & (where <= high)
        rms, mean = float(np.sqrt(np.mean(error[some] ** 2))), float(np.mean(error[some]))
        peak = 520.0 * 0.25 ** (0.5 - 0.5 * float(np.mean(where[some])))
        assert rms <= 1.3 * clipped_bound(Scene(2.0, peak, contrast))
        # half way round rays lie along columns, where no interpolation averages noise: there it is a third larger
        assert 0.8 <= rms / np.sqrt(np.mean(doubt[some] ** 2)) <= 1.3
        assert abs(mean) <= 5 * rms / np.sqrt(some.sum() / 6)


@pytest.mark.parametrize(("width", "peak", "contrast"), [(2.0, 400.0, 0.0), (3.0, 1000.0, 0.3), (1.5, 260.0, 0.2)])
def test_both_kernels_place_clipped_lines_alike(width: float, peak: float, contrast: float) -> None:
    picture, _ = Scene(width, peak, contrast).draw(3)
    ring, _, _ = clipped_ring(peak, contrast, dim=0.4)
    for see in (
        lambda kernel: detect_line(picture, kernel=kernel),
        lambda kernel: detect_ring(ring, (150.0, 150.0), inner=60, outer=140, rays=500, channel="luma", kernel=kernel),
    ):
        native, twin = see("native"), see("numpy")
        np.testing.assert_array_equal(native.status, twin.status)
        np.testing.assert_allclose([native.u, native.v], [twin.u, twin.v], atol=1e-4, rtol=0)
        np.testing.assert_allclose(native.u_position, twin.u_position, rtol=1e-3)


def test_a_plateau_wider_than_the_window_of_a_first_look_is_a_line() -> None:
    """A line of 3 px, four times as bright as white, was taken for other light: its width was never learnt."""
    picture, row = Scene(3.0, 1000.0).draw(0)
    stripe = detect_line(picture)
    assert np.all(stripe.status == Status.SATURATED)
    assert np.abs(stripe.v - row).max() < 0.1


@pytest.mark.parametrize("kernel", ["native", "numpy"])
def test_a_line_so_bright_that_it_is_clipped_everywhere_still_has_places(kernel: str) -> None:
    picture, row = Scene(2.0, 400.0).draw(1)
    stripe = detect_line(picture, kernel=kernel)
    assert np.isfinite(stripe.v).all()
    assert np.sqrt(np.mean((stripe.v - row) ** 2)) <= 1.1 * np.sqrt(np.mean(stripe.u_position**2)) <= 0.011

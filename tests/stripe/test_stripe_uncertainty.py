"""The stated uncertainty of a peak against what it is seen to scatter."""

import numpy as np
import pytest
from stripe_scenes import line_image, speckled_line

from calibore.stripe import detect_line
from calibore.stripe._scatter import observe_scatter


def standard_scores(image: np.ndarray, row: np.ndarray) -> np.ndarray:
    stripe = detect_line(image)
    z = (stripe.v - row) / stripe.u_position
    return z[np.isfinite(z)]


@pytest.mark.parametrize("peak", [40.0, 100.0, 180.0])
@pytest.mark.parametrize("width", [1.2, 2.0, 3.5])
def test_u_matches_the_scatter_without_speckle(peak: float, width: float) -> None:
    z = standard_scores(*line_image(np.random.default_rng(int(peak + 10 * width)), peak=peak, width=width))
    assert 0.9 < np.sqrt(np.mean(z**2)) < 1.1
    assert 0.925 < np.mean(np.abs(z) < 1.96) < 0.975


@pytest.mark.parametrize("contrast", [0.2, 0.35, 0.5])
def test_u_matches_the_scatter_with_speckle(contrast: float) -> None:
    z = np.concatenate([standard_scores(*speckled_line(np.random.default_rng(seed), contrast)) for seed in range(4)])
    assert 0.9 < np.sqrt(np.mean(z**2)) < 1.1
    assert 0.925 < np.mean(np.abs(z) < 1.96) < 0.975


def test_speckle_is_learnt_from_the_image() -> None:
    plain = detect_line(line_image(np.random.default_rng(1))[0]).noise
    speckled = detect_line(speckled_line(np.random.default_rng(1), 0.35)[0]).noise
    assert plain.contrast < 0.01
    assert 0.5 < np.sqrt(speckled.contrast) / 0.35 < 1.5
    assert abs(plain.width - 2.0) < 0.15


def test_scale_and_correlation_of_neighbours_are_recovered() -> None:
    rng, count, blur = np.random.default_rng(4), 6000, 2.0
    weights = np.exp(-(np.arange(-10, 11) ** 2) / (2 * blur**2))
    noise = np.convolve(rng.normal(size=count + 20), weights / np.sqrt(np.sum(weights**2)), mode="valid")
    smooth = 100 + 3 * np.sin(np.arange(count) * 2 * np.pi / count)
    seen = observe_scatter(smooth + 0.17 * noise, np.full(count, 0.1), width=2.0, spacing=1.0, closed=True)
    expected = np.exp(-(np.arange(1, seen.correlation.size + 1) ** 2) / (4 * blur**2))
    assert seen.scale == pytest.approx(1.7, rel=0.06)  # 6000 / (2 blur sqrt(pi)) independent numbers: 2 % twice over
    np.testing.assert_allclose(seen.correlation, expected, atol=0.08)


def test_independent_noise_is_not_called_correlated() -> None:
    rng = np.random.default_rng(9)
    seen = observe_scatter(rng.normal(size=5000), np.ones(5000), width=1.0, spacing=1.0, closed=False)
    assert np.all(seen.correlation < 0.1)
    assert seen.scale == pytest.approx(1.0, rel=0.06)

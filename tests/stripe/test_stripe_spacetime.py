"""The moment at which a line passes over a place, from the light that the place returns."""

import numpy as np
import pytest

from calibore.stripe import NoiseModel, brightness_at, passages

NOISE = NoiseModel(additive=4.0, gain=0.1, contrast=0.01, width=2.0, grain=1.0)


def pulses(rng, count, *, width, step, height=(40.0, 180.0), background=(5.0, 20.0)):
    """Samples (m, n) of a line that passes at the moments (n,), at (m, 1)."""
    moments = np.arange(-4.0, 4.01, step)[:, None] * width
    true = rng.uniform(-0.8, 0.8, count) * width
    tall = rng.uniform(*height, count)
    light = tall * np.exp(-0.5 * ((moments - true) / width) ** 2)
    noisy = light + rng.normal(size=light.shape) * np.sqrt(NOISE.variance(light))
    return noisy + rng.uniform(*background, count), np.broadcast_to(moments, light.shape), true


@pytest.mark.parametrize("step", [0.25, 0.5, 1.0])
def test_moments_are_unbiased_and_as_uncertain_as_stated(step):
    """2000 passages: the mean error below 4 standard errors, error / u of unit spread within 6 %."""
    rng = np.random.default_rng(int(100 * step))
    samples, moments, true = pulses(rng, 2000, width=0.7e-3, step=step)
    passage = passages(list(samples), moments, width=np.full(2000, 0.7e-3), noise=NOISE)
    z = (passage.moment - true) / passage.u
    assert np.isfinite(z).mean() > 0.995
    z = z[np.isfinite(z)]
    assert abs(z.mean()) < 4 / np.sqrt(z.size)
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.06)


def test_a_place_that_returns_nothing_has_no_moment():
    """Noise alone is taken for a passage in less than 2 % of places."""
    rng = np.random.default_rng(5)
    samples, moments, _ = pulses(rng, 2000, width=1.0, step=0.5, height=(0.0, 0.0))
    passage = passages(list(samples), moments, width=np.ones(2000), noise=NOISE)
    assert np.isfinite(passage.moment).mean() < 0.02


def test_samples_outside_the_picture_or_white_are_left_out():
    image = np.add.outer(10 * np.arange(20), np.arange(25)).astype(np.uint8)
    image[12, 12] = 255
    u, v = np.array([2.5, 21.0, 24.5, -0.1, 11.6]), np.array([3.25, 16.0, 3.0, 3.0, 12.0])
    seen = brightness_at(image, u, v, channel="red")
    assert seen[:2] == pytest.approx([35.0, 181.0], rel=0.01)  # what six taps of Lanczos make of a slope
    assert np.isnan(seen[2:]).all()
    rng = np.random.default_rng(8)
    samples, moments, true = pulses(rng, 500, width=1.0, step=0.5)
    samples[rng.random(samples.shape) < 0.2] = np.nan
    passage = passages(list(samples), moments, width=np.ones(500), noise=NOISE)
    assert np.nanmedian(np.abs(passage.moment - true) / passage.u) < 0.8

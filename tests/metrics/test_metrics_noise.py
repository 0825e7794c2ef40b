"""The noise of a ring: a covariance, whatever correlations were estimated."""

import numpy as np
import pytest

from calibore.metrics import RingShape, ring_quantities
from calibore.metrics._noise import Noise

POSITIONS = 400


@pytest.mark.parametrize("correlation", [[0.9], [0.8, 0.1], [0.95, 0.8, 0.1, 0.0], [-0.7, 0.6], [0.3, 0.1]])
def test_every_stretch_has_a_covariance(correlation):
    noise = Noise(np.full(POSITIONS, 2.0), np.array(correlation))
    for index in (np.arange(60), np.arange(380, 440) % POSITIONS, np.arange(0, 400, 7)):
        assert np.linalg.eigvalsh(noise.block(index)).min() > 0
        np.testing.assert_allclose(np.diag(noise.block(index)), 4.0)


def test_correlations_that_noise_can_have_stay_as_they_are():
    correlation = np.array([0.5, 0.2, 0.05])
    np.testing.assert_array_equal(Noise(np.ones(POSITIONS), correlation).correlation, correlation)


def test_a_ring_with_a_dent_whose_correlations_were_cut_off_is_measured():
    rng = np.random.default_rng(4)
    clock = np.arange(POSITIONS) * 2 * np.pi / POSITIONS
    smooth = np.convolve(np.tile(rng.standard_normal(POSITIONS), 3), np.ones(8) / 8, "same")[POSITIONS : 2 * POSITIONS]
    dent = 0.004 * np.exp(-0.5 * ((clock - 2) / 0.1) ** 2)
    u = np.full(POSITIONS, 1e-4)
    lags = np.array([0.95, 0.85, 0.7])
    shape = RingShape(clock, 0.15 - dent + 3e-4 * smooth, u, correlation=lags)
    found = ring_quantities(shape, nominal_radius=0.15)
    assert abs(found.diameter_mean.value - 0.3) < 2e-3

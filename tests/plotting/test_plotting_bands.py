"""What a band of radii is predicted to hold: 95 % of errors of which each has its own size."""

import numpy as np
import pytest

from calibore.plotting._bands import bands_of, holding


def test_equal_uncertainties_give_1_96_of_them():
    assert holding(np.full(50, 0.002)) == pytest.approx(1.95996 * 0.002, rel=1e-5)


def test_few_large_uncertainties_widen_a_band_as_far_as_they_count():
    rng = np.random.default_rng(3)
    for share in (0.02, 0.1, 0.4):
        u = np.where(np.arange(200_000) < share * 200_000, 0.05, 0.005)
        errors = np.abs(u * rng.standard_normal(u.size))
        # 200 000 draws tell a share of 95 % to 0.05 %
        assert np.mean(errors <= holding(u)) == pytest.approx(0.95, abs=0.002)


def test_a_band_with_few_points_says_nothing():
    found = bands_of(np.array([1.0] * 20 + [2.0] * 5), np.zeros(25), np.ones(25), count=2)
    assert np.isfinite(found.predicted[0])
    assert np.isnan(found.predicted[1])

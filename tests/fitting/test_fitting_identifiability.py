"""What the data cannot tell is said, not hidden."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.fitting import identifiability, least_squares

RADIUS = np.linspace(40, 400, 60)  # px
NAMES = ("camera.k", "baseline", "offset")


def _range_fit(noise: float = 1e-4, **prior):
    """A flat target at one distance: R = D r / k + offset."""
    measured = 0.2 * RADIUS / 800 + 0.003 + noise * np.random.default_rng(1).normal(size=RADIUS.size)

    def model(b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        k, distance, offset = b
        slopes = np.column_stack([-distance * RADIUS / k**2, RADIUS / k, np.ones(RADIUS.size)])
        return measured - distance * RADIUS / k - offset, slopes

    return least_squares(model, [700.0, 0.25, 0.0], names=NAMES, **prior)


def test_only_the_ratio_of_distance_and_lens_constant_is_identifiable():
    fit = _range_fit()
    found = identifiability(fit)
    assert found.rank == 2
    assert not found.complete
    assert set(found.weakest) == {"camera.k", "baseline"}
    assert found.weakest_change["camera.k"] == pytest.approx(found.weakest_change["baseline"])
    assert found.pairs[0][:2] == ("camera.k", "baseline")
    assert found.pairs[0][2] == pytest.approx(1)
    assert "camera.k" in str(found)
    assert "change together" in str(found)


def test_what_is_not_identifiable_has_no_finite_uncertainty():
    fit = _range_fit()
    assert np.isinf(fit.u[:2]).all()
    assert fit.u[2] == pytest.approx(
        1e-4 * np.sqrt(1 / 60 + RADIUS.mean() ** 2 / np.sum((RADIUS - RADIUS.mean()) ** 2)), rel=0.3
    )
    assert fit.value("baseline") / fit.value("camera.k") == pytest.approx(0.2 / 800, rel=1e-3)


def test_a_known_distance_makes_the_lens_constant_identifiable():
    fit = _range_fit(prior=(["baseline"], [0.2], [[1e-8]]))
    found = identifiability(fit)
    assert found.complete
    assert fit.value("camera.k") == pytest.approx(800, abs=4 * fit.u[0])
    assert fit.u[0] / 800 > 1e-4 / 0.2


def test_a_badly_known_distance_leaves_a_correlation_that_is_reported():
    found = identifiability(_range_fit(prior=(["baseline"], [0.2], [[1e-4]])))
    assert found.complete
    assert {*found.pairs[0][:2]} == {"camera.k", "baseline"}
    assert found.pairs[0][2] > 0.999
    assert "cannot be told apart" in str(found)


def test_a_parameter_without_effect_is_found():
    x = np.column_stack([np.ones(20), np.zeros(20)])
    y = np.random.default_rng(2).normal(size=20)
    fit = least_squares(lambda b: (y - x @ b, x), [0.0, 1.0], names=["a", "idle"])
    found = identifiability(fit)
    assert (found.rank, list(found.weakest)) == (1, ["idle"])
    assert np.isinf(fit.u[1])
    assert np.isfinite(fit.u[0])


def test_shares_of_the_weakest_direction_add_up():
    found = identifiability(_range_fit(prior=(["baseline"], [0.2], [[1e-4]])))
    assert sum(found.weakest.values()) == pytest.approx(1, abs=0.03)
    assert list(found.weakest.values()) == sorted(found.weakest.values(), reverse=True)


def test_knowing_beforehand_needs_a_proper_covariance():
    with pytest.raises(InputError, match="positive definite"):
        _range_fit(prior=(["baseline", "offset"], [0.2, 0.0], [[1e-4, 1e-4], [1e-4, 1e-4]]))
    with pytest.raises(InputError, match="not fitted"):
        _range_fit(prior=(["camera.c1"], [0.2], [[1e-4]]))

"""Covariances are what they say, and propagate as the GUM prints."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.uncertainty import Covariance, Quantity, propagate


def random_covariance(rng, p, rank):
    columns = rng.normal(size=(p, rank)) * 10.0 ** rng.uniform(-6, 3, (p, 1))  # metres beside pixels
    return Covariance(tuple(f"q{i}" for i in range(p)), columns @ columns.T)


def test_factor_reproduces_the_matrix_singular_ones_and_unlike_units_included():
    rng = np.random.default_rng(1)
    for _ in range(200):
        p = int(rng.integers(1, 9))
        covariance = random_covariance(rng, p, int(rng.integers(1, p + 1)))
        factor, scale = covariance.factor(), np.outer(covariance.u, covariance.u)
        assert np.abs((factor @ factor.T - covariance.matrix) / scale).max() < 1e-13


def test_gum_h2_resistance_reactance_and_impedance():
    volt, ampere, phase = 4.999, 0.019661, 1.04446
    u = np.array([0.0032, 9.5e-6, 7.5e-4])
    correlation = np.array([[1, -0.36, 0.86], [-0.36, 1, -0.65], [0.86, -0.65, 1]])
    inputs = Covariance(("V", "I", "phi"), correlation * np.outer(u, u))
    z = volt / ampere
    slopes = np.array(
        [
            [np.cos(phase) / ampere, -z * np.cos(phase) / ampere, -z * np.sin(phase)],
            [np.sin(phase) / ampere, -z * np.sin(phase) / ampere, z * np.cos(phase)],
            [1 / ampere, -z / ampere, 0],
        ]
    )
    modes, u_out = propagate(slopes, inputs)
    assert np.allclose(u_out, [0.070, 0.295, 0.237], rtol=0, atol=1e-3)  # H.2 prints 0.071, 0.295, 0.236
    correlations = (modes.T @ modes) / np.outer(u_out, u_out)
    assert np.allclose(correlations[[0, 0, 1], [1, 2, 2]], [-0.59, -0.49, 0.99], rtol=0, atol=0.006)


def test_modes_carry_the_full_covariance_of_the_results():
    rng = np.random.default_rng(2)
    covariance, slopes = random_covariance(rng, 4, 3), rng.normal(size=(50, 4))
    modes, u = propagate(slopes, covariance)
    full = slopes @ covariance.matrix @ slopes.T
    assert np.allclose(modes.T @ modes, full, atol=1e-12 * full.max())
    assert np.allclose(u, np.sqrt(np.diag(full)), rtol=1e-9)


def test_uncorrelated_parameters_have_one_mode_each():
    modes, u = propagate(np.array([[2.0, 3.0]]), Covariance.independent({"a": 0.1, "b": 0.2}))
    assert np.allclose(np.sort(np.abs(modes[:, 0])), [0.2, 0.6])
    assert u[0] == pytest.approx(np.hypot(0.2, 0.6))


def test_columns_are_found_by_name_and_parameters_without_covariance_are_exact():
    slopes = np.array([[1.0, 10.0, 100.0]])
    covariance = Covariance.independent({"c": 1.0, "a": 2.0})
    assert propagate(slopes, covariance, names=("a", "b", "c")).u[0] == pytest.approx(np.hypot(100, 2))
    with pytest.raises(InputError, match=r"No parameter is called c; present: a, b"):
        propagate(slopes[:, :2], covariance, names=("a", "b"))
    with pytest.raises(InputError, match="3 columns"):
        propagate(slopes, covariance)


def test_a_missing_result_is_missing_alone():
    u = propagate(np.array([[1.0], [np.nan], [2.0]]), Covariance.independent({"a": 0.1})).u
    assert np.allclose(u, [0.1, np.nan, 0.2], equal_nan=True)


def test_parts_and_unions_keep_their_entries():
    rng = np.random.default_rng(3)
    covariance = random_covariance(rng, 4, 4)
    part = covariance.restricted(("q2", "q0"))
    assert part.matrix[0, 1] == covariance.matrix[2, 0]
    joined = part.joined(Covariance.independent({"x": 2.0}))
    assert joined.names == ("q2", "q0", "x")
    assert joined.matrix[2].tolist() == [0, 0, 4]
    with pytest.raises(InputError, match="No parameter is called q9"):
        covariance.restricted(("q9",))


@pytest.mark.parametrize(
    ("names", "matrix", "sentence"),
    [
        (("a", "a"), np.eye(2), "unique"),
        (("a",), np.eye(2), r"shape \(1, 1\), got \(2, 2\)"),
        (("a", "b"), [[1, 0.5], [0.4, 1]], "symmetric"),
        (("a", "b"), [[1e-8, 1.1e-4], [1.1e-4, 1.0]], "positive semi-definite"),
        (("a", "b"), [[1, 0], [0, -1]], "variance of b is -1"),
        (("a", "b"), [[0, 0.1], [0.1, 1]], "without variance"),
        (("a",), [[np.nan]], "finite"),
    ],
)
def test_what_is_no_covariance_is_refused_with_a_sentence(names, matrix, sentence):
    with pytest.raises(InputError, match=sentence):
        Covariance(names, np.array(matrix))


def test_an_exactly_known_parameter_is_no_mistake():
    assert propagate(np.array([[3.0]]), Covariance.independent({"a": 0.0})).u[0] == 0.0


def test_a_quantity_states_its_interval_and_refuses_a_negative_uncertainty():
    assert Quantity(2.0, 0.5).interval(2) == (1.0, 3.0)
    low, high = Quantity(0.0, 1.0).interval()
    assert (low, high) == pytest.approx((-1.96, 1.96), abs=1e-3)
    with pytest.raises(InputError, match="not be negative"):
        Quantity(1.0, -0.1)

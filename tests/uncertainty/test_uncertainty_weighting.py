"""Weights of least variance: no other weights do better, and what is shared is not averaged away."""

import numpy as np

from calibore.uncertainty import least_variance_weights


def variance(weights, independent, modes):
    return np.sum((weights * independent) ** 2, axis=0) + np.sum(
        np.einsum("l...,lm...->m...", weights, modes) ** 2, axis=0
    )


def test_no_other_weights_give_a_smaller_variance():
    rng = np.random.default_rng(0)
    for measurements in (2, 3, 4):
        independent = rng.uniform(0.1, 1.0, (measurements, 500))
        modes = rng.normal(0, 0.15, (measurements, 2, 500))
        weights = least_variance_weights(independent, modes)
        assert np.allclose(weights.sum(axis=0), 1.0)
        least = variance(weights, independent, modes)
        inside = (weights > 0).all(axis=0)  # there the constraint does not bind
        assert inside.mean() > 0.5
        for _ in range(50):
            others = rng.dirichlet(np.ones(measurements), 500).T
            assert (variance(others, independent, modes) >= least * (1 - 1e-9))[inside].all()


def test_two_measurements_follow_the_closed_form():
    rng = np.random.default_rng(1)
    u, modes = rng.uniform(0.1, 1, (2, 300)), rng.normal(0, 0.5, (2, 3, 300))
    a, b = u**2 + np.sum(modes**2, axis=1)
    shared = np.sum(modes[0] * modes[1], axis=0)
    witness = np.clip((b - shared) / (a + b - 2 * shared), 0, 1)
    assert np.allclose(least_variance_weights(u, modes)[0], witness, atol=1e-9)


def test_what_two_measurements_share_is_counted_once():
    weights = least_variance_weights(np.array([0.1, 0.1]), np.array([[1.0], [1.0]]))
    assert np.allclose(weights, 0.5)
    assert np.isclose(variance(weights, np.array([0.1, 0.1]), np.array([[1.0], [1.0]])), 1.0 + 0.01 / 2)


def test_a_measurement_that_is_not_there_has_no_weight():
    weights = least_variance_weights(np.array([[0.1, np.nan, np.nan], [0.5, 0.5, np.nan]]), np.zeros((2, 1, 3)))
    assert weights[:, 1].tolist() == [0.0, 1.0]
    assert weights[:, 2].tolist() == [0.0, 0.0]
    assert weights[0, 0] > 0.9


def test_a_measurement_that_only_tells_of_common_errors_gets_nothing():
    assert least_variance_weights(np.array([0.1, 0.1]), np.array([[1.0], [3.0]])).tolist() == [1.0, 0.0]

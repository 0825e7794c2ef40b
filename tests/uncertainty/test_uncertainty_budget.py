"""Budgets add up, expanded uncertainties are the GUM's, and a mean keeps what its points share."""

import json

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.uncertainty import (
    Covariance,
    Quantity,
    budget,
    budget_of_mean,
    coverage_factor,
    effective_degrees_of_freedom,
    propagate,
)


def random_inputs(rng, p):
    columns = rng.normal(size=(p, p)) * 10.0 ** rng.uniform(-6, 3, (p, 1))
    return Covariance([f"q{i}" for i in range(p)], columns @ columns.T)


def test_gum_h1_end_gauge_has_16_degrees_of_freedom_and_93_nm():
    comparator = effective_degrees_of_freedom([5.8, 3.9, 6.7], [24, 5, 8])
    assert comparator == pytest.approx(25.6, abs=0.2)  # the GUM rounds the combined 9.68 to 9.7
    gauge = budget(
        np.ones(4),
        Covariance.independent(
            {"standard": 25.0, "comparator": 9.7, "expansion": 2.9, "temperature": 16.6},
            distributions={"expansion": "rectangular", "temperature": "rectangular"},
            degrees_of_freedom={"standard": 18, "comparator": float(comparator), "expansion": 50, "temperature": 2},
        ),
    )
    assert gauge.u[0] == pytest.approx(32, abs=0.5)
    assert int(gauge.degrees_of_freedom[0]) == 16
    assert coverage_factor(0.99, 16) == pytest.approx(2.92, abs=0.005)
    assert 32 * coverage_factor(0.99, 16) == pytest.approx(93, abs=0.5)
    assert gauge.expanded(0.99)[0] == pytest.approx(93, abs=1.5)  # the GUM rounds 31.7 to 32 and 16.7 to 16


def test_coverage_factors_are_those_of_table_g2():
    nu = [1, 2, 5, 10, 20, 50, np.inf]
    assert coverage_factor(0.95, nu) == pytest.approx([12.71, 4.30, 2.57, 2.23, 2.09, 2.01, 1.960], abs=0.005)
    assert coverage_factor(0.6827, [3, np.inf]) == pytest.approx([1.20, 1.00], abs=0.005)
    assert coverage_factor() == pytest.approx(1.959963984540054, rel=1e-15)


def test_shares_sum_to_a_hundred_and_variances_to_the_propagated_ones():
    rng = np.random.default_rng(1)
    for _ in range(50):
        p = int(rng.integers(1, 8))
        covariance, c = random_inputs(rng, p), rng.normal(size=(20, p))
        stripe = rng.uniform(0, 1, 20)
        found = budget(c, covariance, independent={"stripe": stripe})
        assert np.allclose(found.u, np.hypot(propagate(c, covariance).u, stripe), rtol=1e-9)
        assert np.allclose(found.shares.sum(axis=1), 100, atol=1e-6)
        assert np.allclose(found.u**2, found.u_common**2 + found.u_independent**2, rtol=1e-9)
        assert sum(row["share"] for row in found.table()) == pytest.approx(100, abs=1e-6)


def test_an_input_that_cancels_another_has_a_negative_share():
    covariance = Covariance.correlated({"a": 1.0, "b": 0.5}, {("a", "b"): -0.9})
    shares = budget([1.0, 1.0], covariance).shares[0]
    assert shares == pytest.approx([100 * 0.55 / 0.35, -100 * 0.2 / 0.35])


def test_a_table_is_plain_and_sorted_with_names_matched_to_columns():
    covariance = Covariance.independent(
        {"b": 0.1, "a": 2.0}, distributions={"b": "arcsine"}, degrees_of_freedom={"a": 5}
    )
    found = budget(
        [[3.0, 10.0, 7.0], [np.nan, 10.0, 7.0]], covariance, names=("a", "b", "exact"), independent={"s": [0.5, 2]}
    )
    rows = json.loads(json.dumps(found.table(0), allow_nan=False))
    assert [row["name"] for row in rows] == ["a", "b", "s"]
    assert rows[0] == {
        "name": "a",
        "u": 2.0,
        "distribution": "normal",
        "degrees_of_freedom": 5.0,
        "sensitivity": 3.0,
        "contribution": 6.0,
        "share": pytest.approx(100 * 36 / 37.25),
        "common": True,
    }
    stripe = next(row for row in rows if row["name"] == "s")
    assert (stripe["u"], stripe["sensitivity"], stripe["degrees_of_freedom"], stripe["common"]) == (
        None,
        None,
        None,
        False,
    )
    assert np.isnan(found.u[1])
    assert json.dumps(found.table(1), allow_nan=False)
    assert found.table() == found.table(0)  # what does not exist is left out of the rms


def test_the_rms_over_a_ring_is_the_rms():
    rng = np.random.default_rng(2)
    covariance, c = random_inputs(rng, 3), rng.normal(size=(40, 3))
    each = budget(c, covariance, independent={"stripe": rng.uniform(0, 2, 40)})
    whole = each.rms()
    assert whole.u[0] == pytest.approx(np.sqrt(np.mean(each.u**2)))
    assert whole.contributions[0] == pytest.approx(np.sqrt(np.mean(each.contributions**2, axis=0)))


def test_a_mean_over_a_ring_keeps_the_common_part_and_averages_the_independent_one():
    covariance = Covariance.independent({"baseline": 0.2})
    n, c = 400, np.ones((400, 1))
    mean = budget_of_mean(c, covariance, independent={"stripe": np.full(n, 2.0)})
    assert mean.u_common[0] == pytest.approx(0.2)
    assert mean.u_independent[0] == pytest.approx(2.0 / np.sqrt(n))
    neighbours = budget_of_mean(c, covariance, independent={"stripe": 2.0}, correlation=[0.29])
    assert neighbours.u_independent[0] == pytest.approx(2.0 * np.sqrt((1 + 2 * 0.29) / n))
    shared = budget_of_mean(c, covariance, independent={"stripe": 2.0}, correlation=np.ones((n, n)))
    assert shared.u_independent[0] == pytest.approx(2.0)


def test_a_tilt_cancels_in_the_mean_of_a_ring_though_every_point_feels_it():
    clock = np.arange(360) * np.pi / 180
    tilt = Covariance.independent({"tilt": 1.0})
    assert budget(np.cos(clock)[:, None], tilt).rms().u[0] == pytest.approx(np.sqrt(0.5))
    assert budget_of_mean(np.cos(clock)[:, None], tilt).u[0] < 1e-12


def test_weighted_means_are_those_of_full_propagation_with_missing_points_left_out():
    rng = np.random.default_rng(3)
    covariance, c, w = random_inputs(rng, 3), rng.normal(size=(30, 3)), rng.uniform(0.1, 1, 30)
    noise = rng.uniform(1, 2, 30)
    c[4], w[4] = np.nan, 5.0
    found = budget_of_mean(c, covariance, weights=w, independent={"stripe": noise}, correlation=[0.3, 0.1])
    here = np.arange(30) != 4
    w = w[here] / w[here].sum()
    lag = np.abs(np.subtract.outer(np.flatnonzero(here), np.flatnonzero(here)))
    lag = np.minimum(lag, 30 - lag)
    r = np.select([lag == 0, lag == 1, lag == 2], [1.0, 0.3, 0.1])
    full = c[here] @ covariance.matrix @ c[here].T + r * np.outer(noise[here], noise[here])
    assert found.u[0] == pytest.approx(np.sqrt(w @ full @ w), rel=1e-9)


def test_correlated_inputs_of_one_calibration_count_as_one_term():
    fit = Covariance.correlated(
        {"slope": 1.0, "intercept": 2.0},
        {("slope", "intercept"): -0.9},
        degrees_of_freedom={"slope": 9, "intercept": 9},
    )
    assert budget([3.0, 1.0], fit).degrees_of_freedom[0] == pytest.approx(9)
    rest = Covariance.independent({"gauge": 0.5}, degrees_of_freedom={"gauge": 4})
    group = propagate(np.array([[3.0, 1.0]]), fit).u[0]
    expected = (group**2 + 0.25) ** 2 / (group**4 / 9 + 0.5**4 / 4)
    assert budget([3.0, 1.0, 1.0], fit.joined(rest)).degrees_of_freedom[0] == pytest.approx(expected)
    scatter = budget([[0.0]], Covariance.independent({"a": 1.0}), independent={"s": 3.0}, degrees_of_freedom={"s": 7})
    assert scatter.degrees_of_freedom[0] == pytest.approx(7)


def test_degrees_of_freedom_lie_between_the_fewest_and_the_sum():
    rng = np.random.default_rng(4)
    for _ in range(200):
        k = int(rng.integers(1, 6))
        nu = rng.uniform(1, 50, k)
        found = effective_degrees_of_freedom(10.0 ** rng.uniform(-9, 3, k), nu)
        assert nu.min() * (1 - 1e-12) <= found <= nu.sum() * (1 + 1e-12)
    assert np.isinf(effective_degrees_of_freedom([[1.0, 2.0], [0.0, 0.0]], [np.inf, np.inf])).all()
    assert np.isnan(effective_degrees_of_freedom([np.nan, 1.0], [3, 3]))


def test_a_quantity_with_few_degrees_of_freedom_has_a_wider_interval():
    assert Quantity(1.0, 2.0, 9).expanded() == pytest.approx(2.0 * 2.262, abs=1e-3)
    assert Quantity(1.0, 2.0, 9).interval() == pytest.approx((1 - 4.524, 1 + 4.524), abs=1e-3)
    assert Quantity(1.0, 2.0).expanded(0.9973) == pytest.approx(6.0, abs=1e-3)


ONE = Covariance.independent({"a": 1.0})


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: budget([1.0, 2.0], ONE), "2 columns of sensitivities do not fit 1 parameters"),
        (lambda: budget([1.0, 2.0], ONE, names=("a",)), "1 names do not fit 2 columns"),
        (lambda: budget([1.0], ONE, independent={"a": 1.0}), "a is a common input already"),
        (lambda: budget([1.0], ONE, independent={"s": [1.0, 2.0]}), r"s has shape \(2,\), expected \(1,\)"),
        (lambda: budget([1.0], ONE, degrees_of_freedom={"s": 3}), "No independent part is called s; present: none"),
        (lambda: budget_of_mean([[1.0]] * 4, ONE, weights=[1.0]), "4 results need as many weights, got 1"),
        (lambda: budget_of_mean([[np.nan]], ONE), "at least one result that exists"),
        (lambda: budget_of_mean([[1.0]] * 4, ONE, correlation=[1.2]), "between -1 and 1, got 1.2"),
        (lambda: budget_of_mean([[1.0]] * 4, ONE, correlation=[0.1] * 3), "at most 2 lags"),
        (lambda: coverage_factor(95), "between 0 and 1, got 95; give a fraction"),
        (lambda: coverage_factor(0.95, 0), "above 0, got 0"),
        (lambda: effective_degrees_of_freedom([1.0], [-1]), "above 0, got -1"),
        (lambda: Quantity(1.0, 1.0, 0), "above 0, got 0"),
    ],
)
def test_what_makes_no_budget_is_refused_with_a_sentence(make, sentence):
    with pytest.raises(InputError, match=sentence):
        make()

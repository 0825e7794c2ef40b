"""Monte Carlo gives what the standards print, knows when it has settled, and holds the truth as often as it says."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.uncertainty import Covariance, Method, method_for, monte_carlo, propagate, shortest_interval

TEMPERATURE = np.array([21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511])
CORRECTION = np.array([-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160])


def thermometer():
    """GUM H.3: the line through eleven corrections about 20 degrees, and what is known of it."""
    design = np.stack([np.ones(11), TEMPERATURE - 20], axis=1)
    fitted, squares = np.linalg.lstsq(design, CORRECTION)[:2]
    covariance = np.linalg.inv(design.T @ design) * squares[0] / 9
    return fitted, Covariance(("intercept", "slope"), covariance, None, (9, 9))


def test_gum_h3_thermometer_by_first_order_and_by_monte_carlo():
    fitted, line = thermometer()
    assert np.allclose(fitted, [-0.1712, 0.00218], atol=[5e-5, 5e-6])
    assert np.allclose(line.u, [0.0029, 0.00067], atol=[5e-5, 5e-6])
    assert line.correlation("intercept", "slope") == pytest.approx(-0.930, abs=5e-4)
    at_30 = np.array([1.0, 10.0])
    assert fitted @ at_30 == pytest.approx(-0.1494, abs=5e-5)
    u = propagate(at_30[None], line).u[0]
    assert u == pytest.approx(0.0041, abs=5e-5)
    well_known = Covariance(line.names, line.matrix)
    for inputs, widening in ((well_known, 1.0), (line, np.sqrt(9 / 7))):  # JCGM 101 draws a t of 9 degrees of freedom
        found = monte_carlo(lambda x: x @ at_30, fitted, inputs, rng=np.random.default_rng(1))
        assert found.settled
        assert found.mean[0] == pytest.approx(-0.1494, abs=found.tolerance[0])
        assert found.u[0] == pytest.approx(u * widening, abs=found.tolerance[0])


def test_gum_h2_resistance_reactance_and_impedance_by_monte_carlo():
    inputs = Covariance.correlated(
        {"V": 0.0032, "I": 9.5e-6, "phi": 7.5e-4}, {("V", "I"): -0.36, ("V", "phi"): 0.86, ("I", "phi"): -0.65}
    )

    def model(x):
        z = x[:, 0] / x[:, 1]
        return np.stack([z * np.cos(x[:, 2]), z * np.sin(x[:, 2]), z], axis=1)

    found = monte_carlo(model, [4.999, 0.019661, 1.04446], inputs, rng=np.random.default_rng(2))
    assert found.settled
    assert np.allclose(found.mean, [127.732, 219.847, 254.260], atol=2e-3)  # two units of the last printed digit
    assert np.allclose(found.u, [0.071, 0.295, 0.236], atol=2.5e-3)
    r = found.covariance / np.outer(found.u, found.u)
    assert np.allclose(r[[0, 0, 1], [1, 2, 2]], [-0.588, -0.485, 0.993], atol=0.012)  # stated r have two digits


def test_jcgm_101_sum_of_four_normal_and_of_four_rectangular_inputs():
    names, at = ("a", "b", "c", "d"), np.zeros(4)
    unit = dict.fromkeys(names, 1.0)
    box = dict.fromkeys(names, "rectangular")

    def total(x):
        return x.sum(axis=1)

    normal = monte_carlo(total, at, Covariance.independent(unit), rng=np.random.default_rng(3))
    boxes = monte_carlo(total, at, Covariance.independent(unit, distributions=box), rng=np.random.default_rng(4))
    unlike = Covariance.independent({**unit, "d": 10.0}, distributions=box)
    wide = monte_carlo(total, at, unlike, rng=np.random.default_rng(5))
    exact = 2 * np.sqrt(3) * (2 - 0.6**0.25)  # JCGM 101, 9.2.3: 3.88
    for found, end, u in ((normal, 3.92, 2.0), (boxes, exact, 2.0), (wide, 17.0, np.sqrt(103))):
        assert found.settled
        tolerance = found.tolerance[0]
        assert found.u[0] == pytest.approx(u, abs=tolerance)
        assert np.allclose(found.symmetric[0], [-end, end], atol=tolerance)
        # the shortest of all nearly equally short ones wanders: its length is what is determined
        assert np.ptp(found.shortest[0]) == pytest.approx(2 * end, abs=2 * tolerance)
    assert boxes.symmetric[0, 1] < normal.symmetric[0, 1]


def test_jcgm_101_comparison_loss_where_first_order_sees_nothing():
    u = 0.005
    for r, printed_u, printed_end in ((0.0, 50e-6, 150e-6), (0.9, 67e-6, 185e-6)):
        inputs = Covariance.correlated({"x": u, "y": u}, {("x", "y"): r})
        found = monte_carlo(lambda x: (x**2).sum(axis=1), [0.0, 0.0], inputs, rng=np.random.default_rng(6), digits=2)
        assert propagate(np.zeros((1, 2)), inputs).u[0] == 0
        assert found.mean[0] == pytest.approx(50e-6, abs=1e-6)
        assert found.u[0] == pytest.approx(printed_u, abs=1e-6)
        assert found.shortest[0] == pytest.approx([0, printed_end], abs=2e-6)


def test_intervals_of_a_linear_model_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(7)
    slopes, probability = np.array([1.0, -2.0, 0.5]), 0.9
    inputs = Covariance.correlated(
        {"a": 1.0, "b": 0.7, "c": 2.0}, {("a", "b"): 0.6}, distributions={"b": "triangular", "c": "rectangular"}
    )
    found = monte_carlo(lambda x: x @ slopes, np.zeros(3), inputs, rng=rng, probability=probability)
    errors = inputs.draw(rng, 200_000) @ slopes
    for low, high in (found.symmetric[0], found.shortest[0]):
        assert np.mean((errors > low) & (errors < high)) == pytest.approx(probability, abs=0.006)
    assert found.u[0] == pytest.approx(propagate(slopes[None], inputs).u[0], abs=found.tolerance[0])


def test_regions_of_two_outputs_hold_what_they_say():
    rng = np.random.default_rng(8)
    inputs = Covariance.correlated({"a": 1.0, "b": 1e-3}, {("a", "b"): 0.8})
    found = monte_carlo(lambda x: x, [5.0, 7.0], inputs, rng=rng)
    assert found.ellipsoid_factor == pytest.approx(np.sqrt(-2 * np.log(0.05)), abs=0.02)  # chi-squared, two degrees
    away = (inputs.draw(rng, 200_000) + (np.array([5.0, 7.0]) - found.mean)) / found.u
    low, high = ((found.rectangle - found.mean[:, None]) / found.u[:, None]).T
    assert np.mean(((away > low) & (away < high)).all(axis=1)) == pytest.approx(0.95, abs=0.003)
    twice = monte_carlo(lambda x: np.stack([x[:, 0], -3 * x[:, 0]], axis=1), [5.0, 7.0], inputs, rng=rng)
    assert twice.ellipsoid_factor == pytest.approx(1.96, abs=0.02)  # dependent outputs count once


def test_draws_without_a_result_are_counted_and_left_out():
    inputs = Covariance.independent({"x": 1.0})
    half = monte_carlo(
        lambda x: np.where(x[:, 0] > 0, x[:, 0], np.nan), [0.0], inputs, rng=np.random.default_rng(9), digits=1
    )
    assert half.lost == pytest.approx(0.5, abs=0.01)
    assert half.mean[0] == pytest.approx(np.sqrt(2 / np.pi), abs=0.01)  # of a half normal
    none = monte_carlo(lambda x: x[:, 0] * np.nan, [0.0], inputs, rng=np.random.default_rng(0), most_draws=30_000)
    assert (none.lost, none.settled, none.draws) == (1.0, False, 30_000)
    assert np.isnan([none.mean[0], none.u[0], *none.symmetric[0], *none.shortest[0]]).all()
    few = monte_carlo(
        lambda x: np.where(x[:, 0] > 3.5, x[:, 0], np.inf),
        [0.0],
        inputs,
        rng=np.random.default_rng(1),
        most_draws=50_000,
    )
    assert not few.settled
    assert 3.5 < few.mean[0] < 4.5


def test_more_digits_take_more_draws_and_the_cap_is_told():
    inputs = Covariance.independent({"x": 1.0})

    def drawn(digits, most):
        return monte_carlo(
            lambda x: x[:, 0], [0.0], inputs, rng=np.random.default_rng(2), digits=digits, most_draws=most
        )

    coarse, usual, fine, capped = drawn(1, 10**6), drawn(2, 10**6), drawn(3, 4 * 10**6), drawn(3, 10**5)
    assert coarse.draws <= usual.draws < 10**6 < fine.draws
    assert [d.settled for d in (coarse, usual, fine, capped)] == [True, True, True, False]
    assert capped.draws == 10**5
    assert fine.u[0] == pytest.approx(1.0, abs=2e-3)
    assert np.allclose([fine.symmetric[0], fine.shortest[0]], [-1.96, 1.96], atol=0.03)
    no_variance = Covariance.independent({"x": 1.0}, degrees_of_freedom={"x": 1.5})
    assert not monte_carlo(
        lambda x: x[:, 0], [0.0], no_variance, rng=np.random.default_rng(3), most_draws=200_000
    ).settled


def test_the_same_generator_gives_the_same_numbers_and_a_constant_settles_at_once():
    inputs = Covariance.independent({"x": 1.0, "y": 2.0}, distributions={"y": "rectangular"})
    first, second = (
        monte_carlo(lambda x: x.prod(axis=1), [1.0, 2.0], inputs, rng=np.random.default_rng(4)) for _ in "12"
    )
    assert first.mean == second.mean
    assert np.array_equal(first.shortest, second.shortest)
    constant = monte_carlo(lambda x: 0 * x[:, 0] + 1e6, [1.0, 2.0], inputs, rng=np.random.default_rng(5))
    assert (constant.u[0], constant.mean[0], constant.settled) == (0.0, 1e6, True)


def test_inputs_the_covariance_does_not_name_are_exact():
    inputs = Covariance.independent({"b": 0.1})
    found = monte_carlo(
        lambda x: x[:, 0] * x[:, 1], [10.0, 3.0], inputs, names=("a", "b"), rng=np.random.default_rng(6)
    )
    assert found.u[0] == pytest.approx(1.0, abs=0.05)


def test_a_large_offset_costs_no_digits():
    inputs = Covariance.independent({"x": 1e-6})
    found = monte_carlo(lambda x: x[:, 0], [1e3], inputs, rng=np.random.default_rng(7))
    assert found.u[0] == pytest.approx(1e-6, rel=0.02)


def test_the_shortest_interval_of_a_skew_distribution_is_shorter_and_starts_at_its_edge():
    values = np.random.default_rng(8).exponential(size=(100_000, 2)) * [1.0, 5.0]
    low, high = shortest_interval(values, 0.95)
    assert np.allclose(low / [1, 5], 0, atol=1e-2)
    assert np.allclose(high / [1, 5], -np.log(0.05), atol=0.06)


def test_the_margin_chooses_the_method():
    margins = [np.inf, 4.0, 3.999, 1.001, 1.0, 0.0, -3.0, np.nan]
    first, drawn, none = Method.FIRST_ORDER, Method.MONTE_CARLO, Method.NOT_MEASURABLE
    assert method_for(margins).tolist() == [first, first, drawn, drawn, none, none, none, none]
    assert method_for(2.0) == Method.MONTE_CARLO


ONE = Covariance.independent({"a": 1.0})


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"probability": 95}, "between 0 and 1, got 95"),
        ({"digits": 0}, "at least one significant digit, got 0"),
        ({"most_draws": 10}, "needs 10000, got most_draws = 10"),
        ({"estimates": [1.0, 2.0]}, r"1 inputs need as many estimates, got shape \(2,\)"),
        ({"estimates": [np.nan]}, "Estimates must be finite"),
        ({"model": lambda x: x[:3]}, r"gave shape \(3, 1\) for 10000 draws"),
        ({"names": ("b",)}, "No parameter is called a; present: b"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_a_sentence(wrong, sentence):
    arguments = {"model": lambda x: x[:, 0], "estimates": [1.0], "rng": np.random.default_rng(0), **wrong}
    with pytest.raises(InputError, match=sentence):
        monte_carlo(arguments.pop("model"), arguments.pop("estimates"), ONE, **arguments)

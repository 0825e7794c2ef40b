"""Random deviations have the stated distributions, standard uncertainties and correlations."""

import itertools

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.uncertainty import Covariance, Distribution

N = 200_000
FOUR_SIGMA = 4.5  # some hundred comparisons: none is expected beyond


def pair(first, second, r, **more):
    return Covariance.correlated({"a": 2.0, "b": 0.1}, {("a", "b"): r}, distributions={"a": first, "b": second}, **more)


@pytest.mark.parametrize(("first", "second"), list(itertools.combinations_with_replacement(Distribution, 2)))
def test_draws_of_every_pair_have_the_stated_uncertainties_and_correlation_of_values(first, second):
    rng = np.random.default_rng([1, first.code, second.code])
    for r in (-0.9, -0.3, 0.0, 0.6, 0.88):
        covariance = pair(first, second, r)
        assert covariance.scores.shortfall < 1e-9
        x = covariance.draw(rng, N) / covariance.u
        assert np.abs(x.mean(axis=0)).max() < FOUR_SIGMA / np.sqrt(N)
        fourth = (x**4).mean(axis=0)
        assert np.all(np.abs((x**2).mean(axis=0) - 1) < FOUR_SIGMA * np.sqrt(np.maximum(fourth - 1, 0.05) / N))
        # the quadrature of pairs without closed form is good to 1e-4
        spread = np.std(x[:, 0] * x[:, 1] - r * (x**2).mean(axis=1))
        assert abs(np.corrcoef(x.T)[0, 1] - r) < FOUR_SIGMA * spread / np.sqrt(N) + 1e-4


@pytest.mark.parametrize(
    ("name", "tail"),
    [("rectangular", 1 - 0.9), ("triangular", (1 - 0.9) ** 2), ("arcsine", 1 - 2 / np.pi * np.arcsin(0.9))],
)
def test_draws_stay_within_their_limits_and_fill_them_as_they_say(name, tail):
    a = 3.0
    u = Distribution(name).u_of_limits(a)
    x = Covariance.independent({"x": u}, distributions={"x": name}).draw(np.random.default_rng(3), N)
    assert np.abs(x).max() <= a * (1 + 1e-12)
    assert np.mean(np.abs(x) > 0.9 * a) == pytest.approx(tail, abs=FOUR_SIGMA * np.sqrt(tail / N))


def test_limits_become_standard_uncertainties_as_the_gum_says():
    found = [Distribution(n).u_of_limits(6.0) for n in ("rectangular", "triangular", "arcsine")]
    assert np.allclose(found, [6 / np.sqrt(3), 6 / np.sqrt(6), 6 / np.sqrt(2)], rtol=1e-15)
    with pytest.raises(InputError, match="no limits"):
        Distribution.NORMAL.u_of_limits(1.0)
    with pytest.raises(InputError, match="got -1"):
        Distribution.RECTANGULAR.u_of_limits(-1.0)


def test_two_rectangular_inputs_have_the_scores_of_the_closed_form():
    for r in (-0.95, 0.2, 0.7):
        factor = pair("rectangular", "rectangular", r).scores_factor()
        assert (factor @ factor.T)[0, 1] == pytest.approx(2 * np.sin(np.pi * r / 6), abs=1e-14)


def test_a_correlation_that_two_distributions_cannot_have_comes_as_near_as_it_can_and_says_so():
    covariance = pair("normal", "rectangular", 0.995)
    most = np.sqrt(3 / np.pi)  # of a normal and a rectangular value that rise together
    assert covariance.scores.shortfall == pytest.approx(0.995 - most, abs=1e-6)
    x = covariance.draw(np.random.default_rng(4), N)
    assert np.corrcoef(x.T)[0, 1] == pytest.approx(most, abs=1e-3)


def test_many_inputs_of_all_kinds_keep_their_covariance():
    rng = np.random.default_rng(5)
    for _ in range(5):
        columns = rng.normal(size=(6, 9)) * 10.0 ** rng.uniform(-5, 3, (6, 1))
        kinds = rng.choice(list(Distribution), 6)
        covariance = Covariance([f"q{i}" for i in range(6)], columns @ columns.T, kinds)
        x = covariance.draw(rng, N) / covariance.u
        assert np.abs(x.T @ x / N - covariance.correlations).max() < 6 * np.sqrt(2 / N) + covariance.scores.shortfall


def test_singular_covariances_of_normal_inputs_stay_singular_draw_by_draw():
    rng = np.random.default_rng(6)
    columns = rng.normal(size=(4, 2)) * [[1.0], [1e-3], [1e3], [1.0]]
    nothing = np.linalg.svd(columns.T)[2][2:]  # combinations that are known exactly
    for nu in (np.inf, 9.0):
        x = Covariance("abcd", columns @ columns.T, None, [nu] * 4).draw(rng, 1000)
        assert np.abs(x @ nothing.T).max() < 1e-6 * np.abs(x).max()


def test_few_degrees_of_freedom_widen_normal_draws_to_students_t():
    nu = 6.0
    rng, u = np.random.default_rng(7), 0.3
    x = Covariance.independent({"x": u}, degrees_of_freedom={"x": nu}).draw(rng, N)[:, 0] / u
    assert x.std() == pytest.approx(np.sqrt(nu / (nu - 2)), rel=0.01)  # the sd of a t with kurtosis 6 scatters 0.4 %
    assert np.quantile(x, [0.9, 0.975]) == pytest.approx([1.440, 2.447], abs=0.03)  # JCGM 100, table G.2
    limited = Covariance.independent({"x": u}, distributions={"x": "rectangular"}, degrees_of_freedom={"x": nu})
    assert limited.draw(rng, N).std() == pytest.approx(u, rel=0.005)


def test_parameters_of_one_fit_share_their_t_and_keep_their_correlation():
    nu = {"a": 9.0, "b": 9.0}
    x = pair("normal", "normal", -0.93, degrees_of_freedom=nu).draw(np.random.default_rng(8), N)
    assert np.corrcoef(x.T)[0, 1] == pytest.approx(-0.93, abs=3e-3)
    unlike = pair("normal", "rectangular", 0.7, degrees_of_freedom={"a": 9.0})
    assert unlike.scores.shortfall < 1e-9
    assert np.corrcoef(unlike.draw(np.random.default_rng(9), N).T)[0, 1] == pytest.approx(0.7, abs=0.006)


def test_an_engine_that_draws_itself_gets_the_same_deviations():
    covariance = Covariance.correlated(
        {"a": 1.0, "b": 0.0, "c": 2.0}, {("a", "c"): 0.5}, distributions={"c": "arcsine"}
    )
    scores = covariance.scores
    normals = np.random.default_rng(10).standard_normal((100, 2))
    z = normals @ covariance.scores_factor()[:, [0, 2]].T
    z[:, 2] = Distribution.ARCSINE.deviations(z[:, 2])
    assert scores.codes.tolist() == [0, 0, 3]
    assert np.array_equal(covariance.draw(np.random.default_rng(10), 100), z * scores.u)
    assert not z[:, 1].any()


def test_nothing_uncertain_draws_nothing():
    assert Covariance.independent({}).draw(np.random.default_rng(0), 5).shape == (5, 0)
    assert not Covariance.independent({"a": 0.0}).draw(np.random.default_rng(0), 5).any()


def test_parts_and_unions_keep_distributions_and_degrees_of_freedom():
    first = pair("rectangular", "arcsine", 0.5, degrees_of_freedom={"b": 7})
    joined = first.restricted(("b",)).joined(Covariance.independent({"x": 1.0}, distributions={"x": "triangular"}))
    assert joined.distributions == ("arcsine", "triangular")
    assert joined.degrees_of_freedom == (7.0, np.inf)
    assert first.correlation("b", "a") == pytest.approx(0.5, abs=1e-15)
    assert joined.correlation("b", "x") == 0


ABC = {"a": 1.0, "b": 2.0, "c": 3.0}


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Covariance.correlated(ABC, {("a", "b"): 1.2}), r"a and b is 1\.2; it must lie between -1 and 1"),
        (lambda: Covariance.correlated(ABC, {("a", "b"): np.nan}), r"a and b is nan; it must lie between"),
        (lambda: Covariance.correlated(ABC, {("a", "z"): 0.2}), "No parameter is called z; present: a, b, c"),
        (lambda: Covariance.correlated(ABC, {("a", "a"): 0.2}), "with itself is 1, got 0.2"),
        (lambda: Covariance.correlated(ABC, {("a", "b"): 0.2, ("b", "a"): 0.3}), "given twice"),
        (
            lambda: Covariance.correlated(ABC, {("a", "b"): 0.9, ("a", "c"): 0.9, ("b", "c"): -0.9}),
            r"eigenvalue -0\.8; the correlations of a, b, c contradict each other: bring them nearer to 0",
        ),
        (
            lambda: Covariance.independent({"a": -1.0}),
            "uncertainty of a is -1.0; it must be finite and not be negative",
        ),
        (lambda: Covariance.independent({"a": np.nan}), "uncertainty of a is nan"),
        (lambda: Covariance.independent(ABC, distributions={"a": "cauchy"}), "'cauchy'; choose one of normal, rect"),
        (lambda: Covariance.independent(ABC, distributions={"z": "normal"}), "No parameter is called z"),
        (lambda: Covariance.independent(ABC, degrees_of_freedom={"b": 0}), "of b are 0; they must be above 0"),
        (lambda: Covariance(("a",), [[1.0]], ["normal", "normal"]), "1 parameters need as many distributions, got 2"),
        (lambda: Covariance(("a",), [[1.0]], None, [1.0, 2.0]), "need as many degrees of freedom, got 2"),
        (lambda: Covariance.independent(ABC).correlation("a", "z"), "No parameter is called z"),
    ],
)
def test_what_cannot_be_known_of_inputs_is_refused_with_a_sentence(make, sentence):
    with pytest.raises(InputError, match=sentence):
        make()

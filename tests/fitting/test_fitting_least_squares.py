"""What a fit does with shared errors, outliers, missing values and nonsense."""

import numpy as np
import pytest
from simulated_fits import NAMES, START, TRUTH, Bench

from calibore.errors import InputError
from calibore.fitting import cross_validated, least_squares, mahalanobis, region, region_contains


def _line(rng: np.random.Generator, n: int = 50) -> tuple[np.ndarray, np.ndarray]:
    x = np.column_stack([np.ones(n), np.linspace(-1, 1, n)])
    return x, x @ [2.0, -1.0] + 0.1 * rng.normal(size=n)


def test_the_error_that_groups_share_is_recovered_with_its_degrees_of_freedom():
    rng = np.random.default_rng(5)
    bench = Bench(groups=10, marks=8, group_sigma=0.05)
    fits = [bench.fit(rng) for _ in range(60)]
    # a variance of 8 degrees of freedom scatters by half: its mean over 60 fits by 6 %
    assert np.mean([fit.group_sigma**2 for fit in fits]) == pytest.approx(0.05**2, rel=0.2)
    assert np.mean([fit.noise for fit in fits]) == pytest.approx(0.03, rel=0.05)
    assert np.median([fit.degrees_of_freedom for fit in fits]) == pytest.approx(8, abs=0.5)
    within_rings = [fit.degrees_of_freedom_of([0, 0, 1]) for fit in fits]
    assert np.median(within_rings) > 60


def test_groups_without_an_error_of_their_own_get_none():
    rng = np.random.default_rng(6)
    fits = [Bench(groups=10, marks=8, group_sigma=1e-9).fit(rng) for _ in range(30)]
    assert np.mean([fit.group_sigma == 0 for fit in fits]) > 0.3
    assert np.median([fit.group_sigma for fit in fits]) < 0.03 / np.sqrt(8)


def test_marks_of_few_rings_are_not_independent_data():
    rng = np.random.default_rng(7)
    bench = Bench(groups=10, marks=200, group_sigma=0.05)
    measured = bench.measured(rng)
    grouped, alone = bench.fitted(measured), Bench(groups=10, marks=200).fitted(measured)
    assert grouped.u[0] > 5 * alone.u[0]


def test_outliers_get_no_weight_and_do_not_pull():
    rng = np.random.default_rng(8)
    bench = Bench(groups=10, marks=15, group_sigma=0.05)
    distances = []
    for _ in range(25):
        measured = bench.measured(rng)
        foreign = rng.choice(measured.size, measured.size // 10, replace=False)
        measured[foreign] += rng.choice([-1, 1], foreign.size) * rng.uniform(0.4, 3, foreign.size)
        fit = bench.fitted(measured, robust=True)
        assert (fit.weights[foreign] == 0).all()
        assert np.mean(fit.weights == 0) < 0.12
        distances.append(mahalanobis(fit, TRUTH) <= region(fit).limit)
    assert np.mean(distances) >= 0.84  # 25 draws of 95 %


def test_clean_data_are_kept_by_a_robust_fit():
    rng = np.random.default_rng(9)
    kept = [np.mean(Bench().fitted(Bench().measured(rng), robust=True).weights) for _ in range(20)]
    assert np.mean(kept) > 0.998


def test_a_mark_without_a_value_carries_no_weight():
    rng = np.random.default_rng(10)
    x, y = _line(rng)
    holes = y.copy()
    holes[[3, 17]] = np.nan
    fit = least_squares(lambda b: (holes - x @ b, x), [0.0, 0.0], names=["a", "b"])
    rest = np.isfinite(holes)
    without = least_squares(lambda b: ((y - x @ b)[rest], x[rest]), [0.0, 0.0], names=["a", "b"])
    assert np.allclose(fit.values, without.values, rtol=1e-12)
    assert np.allclose(fit.covariance, without.covariance, rtol=1e-9)
    assert fit.weights.tolist() == rest.astype(float).tolist()


def test_a_step_to_where_the_model_has_no_value_is_refused():
    x = np.linspace(0, 0.95, 60)
    rng = np.random.default_rng(11)
    y = 3 * np.sqrt(1 - x) + 0.01 * rng.normal(size=60)

    def model(b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        root = np.sqrt(b[0] - x)
        return y - b[1] * root, np.column_stack([b[1] / (2 * root), root])

    fit = least_squares(model, [5.0, 0.2], names=["edge", "scale"])
    assert np.allclose(fit.values, [1, 3], atol=5 * fit.u)


def test_nothing_is_stated_where_the_search_ends_at_the_edge_of_the_model():
    x = np.linspace(0, 1, 30)

    def model(b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        root = np.where(b[0] > 2, 1.0, np.nan)
        return -5 + x - b[0] * root - b[1], np.column_stack([np.ones(30) * root, np.ones(30) * 0 + x])

    with pytest.raises(InputError, match="no value"):
        least_squares(model, [4.0, 0.0], names=["a", "b"])


def test_a_parameter_on_a_bound_is_named_with_its_value_and_bound():
    x, y = _line(np.random.default_rng(12))
    with pytest.raises(InputError, match=r"b at -1\.\d+.*0 to 5"):
        least_squares(lambda b: (y - x @ b, x), [0.0, 0.0], names=["a", "b"], bounds={"a": (0, 5), "b": (0, 5)})


def test_too_few_data_and_no_convergence_are_errors(monkeypatch: pytest.MonkeyPatch):
    x, y = _line(np.random.default_rng(13))
    with pytest.raises(InputError, match="at least 3 residuals, got 2"):
        least_squares(lambda b: ((y - x @ b)[:2], x[:2]), [0.0, 0.0], names=["a", "b"])

    monkeypatch.setattr("calibore.fitting._minimise.EVALUATIONS", 3)
    with pytest.raises(InputError, match="did not converge"):
        Bench().fit(np.random.default_rng(13))


def test_known_noise_gives_chi_square_and_infinite_degrees_of_freedom():
    rng = np.random.default_rng(14)
    x = _line(rng)[0]
    inside = []
    for _ in range(200):
        y = _line(rng)[1]
        fit = least_squares(lambda b, y=y: (y - x @ b, x), [0.0, 0.0], names=["a", "b"], sigma=0.1, noise=1.0)
        inside.append(region_contains(fit, [2.0, -1.0]))
    assert fit.degrees_of_freedom == np.inf
    assert region(fit).limit == pytest.approx(5.991, abs=1e-3)  # chi-square, 2 degrees, 95 %
    assert np.allclose(fit.covariance, 0.01 * np.linalg.inv(x.T @ x), rtol=1e-9)
    assert 0.91 <= np.mean(inside) <= 0.985  # 200 draws of 95 %


def test_a_prior_is_absolute_and_holds_what_the_data_do_not_tell():
    x, y = _line(np.random.default_rng(15))
    blind = np.column_stack([x, np.zeros(50)])
    fit = least_squares(
        lambda b: (y - blind @ b, blind), np.zeros(3), names=["a", "b", "c"], prior=(["c"], [7.0], [[0.04]])
    )
    assert fit.value("c") == pytest.approx(7)
    assert fit.u[2] == pytest.approx(0.2)
    assert fit.degrees_of_freedom_of([0, 0, 1]) == np.inf
    assert fit.degrees_of_freedom == pytest.approx(48, abs=0.1)


def test_a_hundred_thousand_residuals_need_no_square_matrix():
    rng = np.random.default_rng(16)
    n, p = 100_000, 4
    x = np.column_stack([np.sin(np.arange(n) * 0.001 * (i + 1)) for i in range(p)])
    noise = rng.normal(size=n)
    noise[1:] += 0.5 * noise[:-1]
    label = np.arange(n) // 5000
    y = x @ np.arange(1.0, p + 1) + noise + rng.normal(size=20)[label]
    fit = least_squares(
        lambda b: (y - x @ b, x), np.zeros(p), names=[f"b{i}" for i in range(p)], groups=label, chains=label
    )
    assert fit.noise == pytest.approx(np.sqrt(1.25), rel=0.02)
    assert mahalanobis(fit, np.arange(1.0, p + 1)) < 25


def test_cross_validation_leaves_out_whole_folds_and_finds_the_noise():
    rng = np.random.default_rng(17)
    bench = Bench()
    measured = bench.measured(rng)

    def fit_without(left_out: np.ndarray) -> np.ndarray:
        def model(b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            prediction, slopes = bench.predicted(b)
            return (measured - prediction)[~left_out], slopes[~left_out]

        values = least_squares(model, START, names=NAMES).values
        return (measured - bench.predicted(values)[0])[left_out]

    assert cross_validated(fit_without, bench.ring) == pytest.approx(0.03, rel=0.15)
    with pytest.raises(InputError, match="at least 2 parts"):
        cross_validated(fit_without, np.zeros(200))

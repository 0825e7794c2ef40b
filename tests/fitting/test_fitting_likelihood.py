"""The restricted likelihood without n x n matrices is that of the n x n matrices."""

import numpy as np
import pytest

from calibore.fitting import information_criteria, least_squares
from calibore.fitting._chains import Autoregression, LagMoments
from calibore.fitting._likelihood import Unknowns, deviance_and_slopes, variance_information
from calibore.fitting._mixed import MixedModel, Scatter

LENGTHS = (40, 3, 25, 1, 1, 60, 12)  # of chains: shorter and longer than the order
PARTIAL = np.array([0.6, -0.3, 0.2])
EXACT = 1e-9  # relative: rounding of sums of some hundred products


def _correlations(chain: Autoregression) -> np.ndarray:
    """Covariance (n, n) of all chains for unit innovations."""
    result, start, correlation = np.zeros((sum(LENGTHS),) * 2), 0, chain.correlation(max(LENGTHS))
    for length in LENGTHS:
        places = np.arange(length)
        result[start : start + length, start : start + length] = correlation[np.abs(places[:, None] - places)]
        start += length
    return result * chain.variances[0]


def _model(rng: np.random.Generator) -> tuple[MixedModel, Scatter]:
    position = np.concatenate([np.arange(length) for length in LENGTHS])
    n = position.size
    loads = np.zeros((n, 9))
    loads[np.arange(n), rng.integers(0, 9, n)] = rng.normal(size=n)
    jacobian = np.linalg.qr(rng.normal(size=(n, 4)))[0]
    residuals = jacobian @ rng.normal(size=4) + loads @ rng.normal(size=9) * 0.5 + rng.normal(size=n) * 0.3
    moments = LagMoments(np.column_stack([jacobian, loads, residuals]), position, PARTIAL.size)
    return MixedModel(moments, 4, rng.normal(size=(2, 5))), Scatter(0.1, 0.2, Autoregression(PARTIAL))


def _dense(model: MixedModel, scatter: Scatter) -> tuple[np.ndarray, ...]:
    """Covariance V of data and prior, C of the parameters, P, residuals, and the derivatives of V."""
    table, p, known = model.moments.table, model.parameters, len(model.known)
    loads, n = table[:, p:-1], len(table)

    def padded(matrix: np.ndarray, corner: float) -> np.ndarray:
        result = corner * np.eye(n + known)
        result[:n, :n] = matrix
        return result

    neighbours = _correlations(scatter.chain)
    v = padded(scatter.innovation * neighbours + scatter.group * loads @ loads.T, 1.0)
    x = np.concatenate([table[:, :p], model.known[:, :-1]])
    inverse = np.linalg.inv(v)
    c = np.linalg.inv(x.T @ inverse @ x)
    p_matrix = inverse - inverse @ x @ c @ x.T @ inverse
    residuals = np.concatenate([table[:, -1], model.known[:, -1]])
    return v, c, p_matrix, residuals, padded(neighbours, 0.0), padded(loads @ loads.T, 0.0)


def test_a_chain_is_whitened_exactly():
    chain = Autoregression(PARTIAL)
    position = np.concatenate([np.arange(length) for length in LENGTHS])
    white = chain.whitener(position).toarray()
    assert np.allclose(white @ _correlations(chain) @ white.T, np.eye(position.size), atol=1e-12)


def test_deviance_covariance_and_information_are_those_of_dense_matrices():
    for seed in range(5):
        model, scatter = _model(np.random.default_rng(seed))
        v, c, p, residuals, *slopes = _dense(model, scatter)
        solution = model.at(scatter)
        deviance = np.linalg.slogdet(v)[1] + residuals @ p @ residuals
        assert np.allclose(solution.covariance, c, rtol=EXACT, atol=EXACT * np.abs(c).max())
        assert solution.deviance(restricted=False) == pytest.approx(deviance, rel=EXACT)
        assert solution.deviance(restricted=True) == pytest.approx(deviance - np.linalg.slogdet(c)[1], rel=EXACT)
        information = [[np.trace(p @ a @ p @ b) / 2 for b in slopes] for a in slopes]
        assert np.allclose(variance_information(solution), information, rtol=1e-8)


@pytest.mark.parametrize("restricted", [True, False])
def test_slopes_of_the_deviance_agree_with_differences(restricted: bool):
    for seed in range(5):
        model, scatter = _model(np.random.default_rng(seed))
        unknowns = Unknowns(scatter, noise_known=False, group_known=False, unit=0.1)
        vector = unknowns.vector(scatter)
        slopes = deviance_and_slopes(model, unknowns, vector, restricted=restricted)[1]
        for number, step in enumerate(1e-5 * np.eye(vector.size)):
            above, below = (
                deviance_and_slopes(model, unknowns, vector + sign * step, restricted=restricted)[0] for sign in (1, -1)
            )
            # differences of numbers of some hundred leave 1e-13 / 1e-5 of rounding
            assert slopes[number] == pytest.approx((above - below) / 2e-5, abs=1e-4)


def test_criteria_are_those_of_the_normal_likelihood():
    rng = np.random.default_rng(3)
    x, sigma = rng.normal(size=(60, 3)), rng.uniform(0.5, 2, 60)
    y = x @ [1.0, -2.0, 0.5] + sigma * rng.normal(size=60)
    fit = least_squares(lambda b: (y - x @ b, x), np.zeros(3), names=["a", "b", "c"], sigma=sigma)
    spread = sigma * np.sqrt(np.mean((fit.residuals / sigma) ** 2))
    deviance = np.sum((fit.residuals / spread) ** 2 + np.log(2 * np.pi * spread**2))
    aicc, bic = information_criteria(fit)
    assert aicc == pytest.approx(deviance + 2 * 4 + 2 * 4 * 5 / 55, abs=1e-6)
    assert bic == pytest.approx(deviance + 4 * np.log(60), abs=1e-6)


def test_criteria_find_the_model_that_made_correlated_and_grouped_data():
    """A quadratic seen through rings of correlated marks: neither the line nor the quintic is preferred."""
    rng, found = np.random.default_rng(4), []
    place, ring = np.tile(np.linspace(-1, 1, 30), 8), np.repeat(np.arange(8), 30)
    for _ in range(15):
        noise = rng.normal(size=(8, 30))
        for t in range(1, 30):
            noise[:, t] = 0.6 * noise[:, t - 1] + 0.8 * noise[:, t]
        y = 1 + 0.5 * place - 1.5 * place**2 + 0.2 * noise.ravel() + 0.3 * rng.normal(size=8)[ring]
        bic = []
        for terms in (2, 3, 6):
            x = place[:, None] ** np.arange(terms)
            fit = least_squares(
                lambda b, x=x, y=y: (y - x @ b, x),
                np.zeros(terms),
                names=[f"b{i}" for i in range(terms)],
                groups=ring,
                chains=ring,
            )
            bic.append(information_criteria(fit).bic)
        found.append(np.argmin(bic))
    assert np.mean(np.array(found) == 1) > 0.85

"""Non-linear least squares whose covariance knows of shared errors, neighbours, outliers and prior knowledge."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.fitting._chains import WHITE, Autoregression, LagMoments, order_of
from calibore.fitting._confidence import confidence
from calibore.fitting._fit import Fit, satterthwaite
from calibore.fitting._likelihood import Unknowns, most_likely, unknowns_of
from calibore.fitting._minimise import minimise
from calibore.fitting._mixed import MixedModel, Scatter, Solution
from calibore.fitting._outliers import agreeing, resistant
from calibore.fitting._problem import Mask, Model, Prior, Problem, Rows, check_bounds, posed
from calibore.fitting._rank import basis_of
from calibore.fitting._whitening import whitening

Array = NDArray[np.float64]

ROUNDS = 10
SETTLED = 0.01  # standard uncertainties: a change of parameters that no longer matters
EXACT = 1e-12  # of the largest first residual: noise that is only rounding
FAINTEST = 1e-18  # smallest noise, in the unit of the data


class Known(NamedTuple):
    """Standard deviations that are known beforehand, None where the residuals shall tell."""

    noise: float | None
    group_sigma: float | None


def least_squares(
    model: Model,
    start: ArrayLike,
    *,
    names: Sequence[str],
    sigma: ArrayLike | None = None,
    prior: Prior | None = None,
    groups: ArrayLike | None = None,
    group_loads: ArrayLike | None = None,
    chains: ArrayLike | None = None,
    robust: bool = False,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    noise: float | None = None,
    group_sigma: float | None = None,
) -> Fit:
    """Parameters (p,) that bring the residuals of `model` nearest to nothing, from `start` (p,).

    `model(parameters)` gives residuals (n,), measured minus predicted, and the Jacobian (n, p) of the PREDICTIONS.
    Residuals that are NaN at the start carry no weight; a step to where others become NaN is refused.

    sigma: standard deviations of the residuals relative to each other, one or (n,); absolute with `noise=1`.
    prior: (names, mean, covariance) of parameters known beforehand, absolute.
    groups: whole numbers (n,): residuals of one group share an unknown error of variance group_sigma^2 times their
        `group_loads` (1 if left out: the error is one of the residual); -1 shares nothing.
    chains: whole numbers (n,): residuals of one chain are neighbours in their order; -1 is nobody's neighbour.
    robust: outliers, up to a tenth of the data or more, get weight 0.
    bounds: name -> (low, high); a result that is not inside is an error, not a number.
    noise, group_sigma: known standard deviations; estimated from the residuals where left out.

    Noise, group_sigma and the correlation of neighbours are found by restricted maximum likelihood, the parameters by
    generalised least squares with them. Raises InputError: no convergence, a parameter out of bounds, too few data.
    """
    values = np.array(start, dtype=float)
    problem, usable = posed(
        model, values, names, sigma=sigma, prior=prior, groups=groups, group_loads=group_loads, chains=chains
    )
    _check_count(problem, usable, spare=noise is None)
    values, used = resistant(problem, values, usable) if robust else (values, usable)
    values, used, estimate = _settled(problem, values, used, Known(noise, group_sigma), robust=robust)
    check_bounds(problem.names, values, bounds or {})
    return _fit(problem, values, used, estimate)


class Estimate(NamedTuple):
    rows: Rows
    solution: Solution
    unknowns: Unknowns
    basis: Array
    root: Array


def _settled(
    problem: Problem, values: Array, used: Mask, known: Known, *, robust: bool
) -> tuple[Array, Mask, Estimate]:
    """Parameters, scatter and outliers found in turn until none of them matters to the others."""
    rows = problem.rows(used)
    values = minimise(_whitened(problem, rows, None), values)
    scatter = None
    for _ in range(ROUNDS):
        estimate = _estimated(problem, values, rows, scatter, known)
        scatter = estimate.solution.scatter
        step = estimate.basis @ estimate.solution.step
        finite, agree = _still_used(problem, values, estimate, robust=robust)
        again = agree if robust else finite
        if np.array_equal(again, used) and _negligible(estimate):
            return values, used, estimate
        used, rows = again, problem.rows(again)
        values = minimise(_whitened(problem, rows, scatter), values + step)
    raise InputError("Parameters and scatter of the fit do not settle; add data, or fit without groups or chains.")

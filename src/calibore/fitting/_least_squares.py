"""Non-linear least squares whose covariance knows of shared errors, neighbours, outliers and prior knowledge."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.fitting._chains import WHITE, LagMoments
from calibore.fitting._confidence import confidence
from calibore.fitting._fit import Fit, Ties, satterthwaite
from calibore.fitting._likelihood import Unknowns, most_likely, unknowns_of
from calibore.fitting._minimise import minimise
from calibore.fitting._mixed import MixedModel, Scatter, Solution
from calibore.fitting._order import largest_order, of_likeliest_order
from calibore.fitting._outliers import FAINTEST, agreeing, first_deviation, resistant
from calibore.fitting._problem import Mask, Model, Prior, Problem, Rows, check_bounds, posed
from calibore.fitting._rank import spectrum, triangle
from calibore.fitting._whitening import whitened, whitening

Array = NDArray[np.float64]

ROUNDS = 20
SELECTIONS = 6  # rounds after which the choice of outliers rests
SETTLED = 0.01  # standard uncertainties: a change of parameters that no longer matters
EXACT = 1e-15  # of the largest first residual: noise that is only rounding


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
    """`solution` in the `basis` (p, rank) of the parameters."""

    rows: Rows
    solution: Solution
    unknowns: Unknowns
    basis: Array

    @property
    def step(self) -> Array:
        """Change (p,) of the parameters that the scatter found asks for."""
        return self.basis @ self.solution.step

    @property
    def settled(self) -> bool:
        step = self.solution.step
        return bool(step @ np.linalg.solve(self.solution.covariance, step) < SETTLED**2)


def _settled(
    problem: Problem, values: Array, used: Mask, known: Known, *, robust: bool
) -> tuple[Array, Mask, Estimate]:
    """Parameters, scatter and outliers found in turn until none of them matters to the others."""
    rows = problem.rows(used)
    deviation = known.noise or first_deviation(problem, rows, values)
    scatter = Scatter(deviation**2, (known.group_sigma or 0.0) ** 2, WHITE)
    faintest = max(EXACT * float(np.abs(problem.linearised(values, rows)[0]).max()), FAINTEST)
    for number in range(ROUNDS):
        rough = number == 0 and not problem.plain
        values = minimise(whitened(problem, rows, scatter), values, rough=rough)
        estimate = _estimated(problem, values, rows, known, scatter if number else None, faintest=faintest)
        scatter = estimate.solution.scatter
        again = _used(problem, values, estimate, robust=robust) if number < SELECTIONS else used
        if np.array_equal(again, used) and estimate.settled and not rough:
            return values, used, estimate
        used, rows, values = again, problem.rows(again), values + estimate.step
    raise InputError("Parameters and scatter of the fit do not settle; add data, or fit without groups or chains.")


def _used(problem: Problem, values: Array, estimate: Estimate, *, robust: bool) -> Mask:
    """Residuals with a value at `values`; with `robust` only those that agree with the others."""
    residuals, jacobian = problem.model(values)
    usable = np.isfinite(residuals) & np.isfinite(jacobian).all(axis=1)
    if not robust:
        return usable
    rows = problem.rows(usable)
    return agreeing(usable, rows, residuals[rows.index] / rows.sigma - rows.loads @ estimate.solution.group_errors)


def _estimated(
    problem: Problem, values: Array, rows: Rows, known: Known, scatter: Scatter | None, *, faintest: float
) -> Estimate:
    residuals, jacobian = problem.linearised(values, rows)
    spare = rows.index.size - len(values) + len(problem.aims)
    noise = known.noise or max(float(np.sqrt(residuals @ residuals / max(spare, 1))), faintest)
    basis = spectrum(triangle(np.concatenate([jacobian / noise, problem.known]))).basis
    table = np.column_stack([jacobian @ basis, rows.loads.toarray(), residuals])
    aside = np.column_stack([problem.known @ basis, problem.aims - problem.known @ values])

    def posed_from(start: Scatter) -> tuple[MixedModel, Unknowns]:
        model = MixedModel(LagMoments(table, rows.position, start.chain.order), basis.shape[1], aside)
        known_noise, known_group = known.noise is not None, known.group_sigma is not None
        least = faintest**2
        return model, unknowns_of(model, start, noise_known=known_noise, group_known=known_group, least_noise=least)

    if scatter is not None:
        model, unknowns = posed_from(scatter)
        return Estimate(rows, model.at(most_likely(model, unknowns)), unknowns, basis)
    white = _guessed(residuals, rows, known, spare=spare, faintest=faintest)
    largest = largest_order(rows.position) if (problem.chain >= 0).any() else 0
    return Estimate(rows, *of_likeliest_order(posed_from, white, largest=largest), basis)


def _guessed(residuals: Array, rows: Rows, known: Known, *, spare: int, faintest: float) -> Scatter:
    """Where the search for the scatter begins: groups' means, and what remains without them, taken for white."""
    strength = rows.loads.power(2).sum(axis=0)
    means = (rows.loads.T @ residuals) / np.where(strength > 0, strength, 1.0)
    within = residuals - rows.loads @ means
    noise = within @ within / max(spare - np.count_nonzero(strength), 1)
    noise = max(float(noise), faintest**2) if known.noise is None else known.noise**2
    group = float(np.mean(means**2)) if means.size else 0.0
    return Scatter(noise, group if known.group_sigma is None else known.group_sigma**2, WHITE)


def _fit(problem: Problem, values: Array, used: Mask, estimate: Estimate) -> Fit:
    residuals, jacobian = problem.model(values)
    scatter = estimate.solution.scatter
    white = whitening(estimate.rows, scatter)(problem.linearised(values, estimate.rows)[1])
    root = triangle(np.concatenate([white, problem.known]))
    found, basis = confidence(estimate.solution, estimate.unknowns), estimate.basis
    covariance, modes = basis @ found.covariance @ basis.T, basis @ found.modes @ basis.T
    covariance[spectrum(root).confounded] = np.inf
    each = [satterthwaite(unit, covariance, modes) for unit in np.eye(values.size)]
    return Fit(
        names=problem.names,
        values=values,
        covariance=covariance,
        degrees_of_freedom=min(each),
        residuals=residuals,
        jacobian=jacobian,
        sigma=scatter.noise * problem.sigma,
        weights=used.astype(float),
        noise=scatter.noise,
        group_sigma=float(np.sqrt(scatter.group)),
        partial_autocorrelation=scatter.chain.partial,
        covariance_modes=modes,
        information_root=root,
        ties=_ties(problem, values, estimate.unknowns),
        evidence=(estimate.solution.model, estimate.unknowns, _constant(problem, estimate.rows)),
    )


def _ties(problem: Problem, values: Array, unknowns: Unknowns) -> Ties:
    prior = np.column_stack([problem.known, problem.aims - problem.known @ values])
    group_sigma = float(np.sqrt(unknowns.start.group)) if unknowns.group_known else None
    return Ties(problem.group, problem.load, problem.chain, prior, unknowns.noise_known, group_sigma)


def _constant(problem: Problem, rows: Rows) -> float:
    """What the deviance of residuals of sigma 1 lacks to be that of the data and the prior."""
    count = rows.index.size + problem.aims.size
    prior = np.linalg.svd(problem.known, compute_uv=False)
    return float(count * np.log(2 * np.pi) + 2 * np.log(rows.sigma).sum() - 2 * np.log(prior).sum())


def _check_count(problem: Problem, usable: Mask, *, spare: bool) -> None:
    rows, parameters = int(usable.sum()) + problem.aims.size, len(problem.names)
    needed = parameters + int(spare)
    if rows < needed:
        raise InputError(
            f"{parameters} parameters need at least {needed} residuals, got {rows} that have a value; add data."
        )

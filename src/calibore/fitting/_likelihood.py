"""The scatter that makes the residuals most likely: restricted maximum likelihood (Patterson and Thompson 1971)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._chains import Autoregression
from calibore.fitting._mixed import MixedModel, Scatter, Solution

Array = NDArray[np.float64]

LARGEST_PARTIAL = 6.0  # of artanh(partial autocorrelation): 0.999988
CHAIN_STEP = 1e-4  # of artanh(partial autocorrelation), for derivatives by central differences
WIDEST = 20.0  # of the logarithms of variances, relative to where the search starts
TOLERANCE = 1e-12  # of the deviance, relative
STEEPNESS = 1e-3  # of the deviance, per standard deviation of what is searched for


@dataclass(frozen=True, eq=False)
class Unknowns:
    """What of the scatter is searched for, as a vector: log innovation, log(1 + group / unit), artanh partial.

    The second is linear where groups share little and a logarithm where they share much. `noise` and `group` are
    kept as in `start` where they are known. `least_noise`: variance of an innovation that is only rounding.
    """

    start: Scatter
    noise_known: bool
    group_known: bool
    unit: float
    least_noise: float = 0.0

    def vector(self, scatter: Scatter) -> Array:
        noise = [] if self.noise_known else [np.log(scatter.innovation)]
        group = [] if self.group_known else [np.log1p(scatter.group / self.unit)]
        return np.concatenate([noise, group, np.arctanh(scatter.chain.partial)])

    def scatter(self, vector: Array) -> Scatter:
        values = list(vector)
        chain = Autoregression(np.tanh(values[len(values) - self.start.chain.order :]))
        innovation = self.start.noise**2 / chain.variances[0] if self.noise_known else float(np.exp(values.pop(0)))
        group = self.start.group if self.group_known else self.unit * float(np.expm1(values.pop(0)))
        return Scatter(innovation, group, chain)

    @property
    def only_noise(self) -> bool:
        return not self.noise_known and self.group_known and not self.start.group and not self.start.chain.order

    @property
    def bounds(self) -> list[tuple[float, float]]:
        middle = float(np.log(self.start.innovation))
        least = float(np.log(self.least_noise)) if self.least_noise > 0 else -np.inf
        noise = [] if self.noise_known else [(max(middle - WIDEST, least), middle + WIDEST)]
        group = [] if self.group_known else [(0.0, WIDEST)]
        return [*noise, *group, *[(-LARGEST_PARTIAL, LARGEST_PARTIAL)] * self.start.chain.order]


def unknowns_of(
    model: MixedModel, start: Scatter, *, noise_known: bool, group_known: bool, least_noise: float
) -> Unknowns:
    """What is searched for: `start` gives the order of the chains and what is known."""
    groups = model.at(start).gram[model.parameters : -1, model.parameters : -1]
    group_known = group_known or not groups.size
    unit = 1.0 if group_known else len(groups) / float(np.trace(groups))
    return Unknowns(start, noise_known, group_known, unit, least_noise)


def most_likely(model: MixedModel, unknowns: Unknowns, *, restricted: bool = True) -> Scatter:
    """The scatter with the least deviance."""
    from scipy.optimize import minimize

    vector = unknowns.vector(unknowns.start)
    if not vector.size:
        return unknowns.start
    if unknowns.only_noise and restricted and not model.known.size:
        squares = model.at(unknowns.start).squares * unknowns.start.innovation
        noise = max(squares / (model.rows - model.parameters), unknowns.least_noise)
        return Scatter(noise, 0.0, unknowns.start.chain)
    scale = _doubts(model, unknowns)
    bounds = np.array(unknowns.bounds) / scale[:, None]

    def function(scaled: Array) -> tuple[float, Array]:
        deviance, slopes = deviance_and_slopes(model, unknowns, scaled * scale, restricted=restricted)
        return deviance, slopes * scale

    options = {"ftol": TOLERANCE, "gtol": STEEPNESS, "maxiter": 200}
    found = minimize(function, vector / scale, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return unknowns.scatter(found.x * scale)


def _doubts(model: MixedModel, unknowns: Unknowns) -> Array:
    """Standard deviations of the vector searched for, about: the steps of a search that does not run wild."""
    start = unknowns.start
    variances = variance_information(model.at(start))
    noise = [] if unknowns.noise_known else [variances[0, 0] * start.innovation**2]
    group = [] if unknowns.group_known else [variances[1, 1] * (start.group + unknowns.unit) ** 2]
    chain = model.rows * (1 - start.chain.partial**2)
    return 1 / np.sqrt(np.maximum(np.concatenate([noise, group, chain]), 1.0))


def variance_information(solution: Solution) -> Array:
    """Expected information (2, 2) about the variances of noise and groups: half of tr(P dV P dV)."""
    noise, group = solution.scatter.innovation, solution.scatter.group
    spread, prior, c = solution.left_of_groups, solution.prior_information, solution.covariance
    z, x = solution.groups, solution.parameters
    seen = solution.weighed[z, x] @ c
    both = spread - seen @ prior @ seen.T - group * spread @ spread
    of_group, of_both = float(np.sum(spread**2)), float(np.trace(both))
    share = c @ prior
    whole = solution.model.rows - solution.model.parameters + float(np.sum(share * share.T))
    of_noise = whole - 2 * group * of_both - group**2 * of_group
    return np.array([[of_noise / noise**2, of_both / noise], [of_both / noise, of_group]]) / 2


def deviance_and_slopes(
    model: MixedModel, unknowns: Unknowns, vector: Array, *, restricted: bool
) -> tuple[float, Array]:
    solution = model.at(unknowns.scatter(vector))
    by_noise, by_group = solution.slopes(restricted=restricted)
    slopes = [] if unknowns.noise_known else [by_noise]
    if not unknowns.group_known:
        slopes.append(by_group * (solution.scatter.group + unknowns.unit))
    if unknowns.start.chain.order:
        slopes += _chain_slopes(solution, unknowns, vector, restricted=restricted)
    return solution.deviance(restricted=restricted), np.array(slopes)


def _chain_slopes(solution: Solution, unknowns: Unknowns, vector: Array, *, restricted: bool) -> list[float]:
    by_gram, moments = solution.slopes_by_gram(restricted=restricted), solution.model.moments
    products = moments.contracted(by_gram)

    def part(vector: Array) -> float:
        scatter = unknowns.scatter(vector)
        filters = scatter.chain.filters
        squares = float(np.sum(filters[:, None, :] @ products @ filters[:, :, None])) / scatter.innovation
        return squares + moments.size * float(np.log(scatter.innovation)) + moments.log_covariance(scatter.chain)

    steps = CHAIN_STEP * np.eye(vector.size)[vector.size - unknowns.start.chain.order :]
    return [(part(vector + step) - part(vector - step)) / (2 * CHAIN_STEP) for step in steps]

"""The scatter that makes the residuals most likely: restricted maximum likelihood (Patterson and Thompson 1971)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._chains import Autoregression
from calibore.fitting._mixed import MixedModel, Scatter, Solution

Array = NDArray[np.float64]

LARGEST_PARTIAL = 6.0  # of artanh(partial autocorrelation): 0.999988
CHAIN_STEP = 1e-4  # of artanh(partial autocorrelation), for derivatives by central differences
WIDEST = 30.0  # of the logarithms of variances, relative to where the search starts
TOLERANCE = 1e-10  # of the deviance, relative


@dataclass(frozen=True, eq=False)
class Unknowns:
    """What of the scatter is searched for, as a vector: log innovation, log(1 + group / unit), artanh partial.

    The second is linear where groups share little and a logarithm where they share much. `noise` and `group` are
    kept as in `start` where they are known.
    """

    start: Scatter
    noise_known: bool
    group_known: bool
    unit: float

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
        middle = np.log(self.start.innovation)
        noise = [] if self.noise_known else [(middle - WIDEST, middle + WIDEST)]
        group = [] if self.group_known else [(0.0, WIDEST)]
        return [*noise, *group, *[(-LARGEST_PARTIAL, LARGEST_PARTIAL)] * self.start.chain.order]


def unknowns_of(model: MixedModel, start: Scatter, *, noise_known: bool, group_known: bool) -> Unknowns:
    """What is searched for: `start` gives the order of the chains and what is known."""
    groups = model.at(start).gram[model.parameters : -1, model.parameters : -1]
    group_known = group_known or not groups.size
    return Unknowns(start, noise_known, group_known, 1.0 if group_known else len(groups) / float(np.trace(groups)))


def most_likely(model: MixedModel, unknowns: Unknowns, *, restricted: bool = True) -> Scatter:
    """The scatter with the least deviance."""
    from scipy.optimize import minimize

    vector = unknowns.vector(unknowns.start)
    if not vector.size:
        return unknowns.start
    if unknowns.only_noise and restricted and not model.known.size:
        squares = model.at(unknowns.start).squares * unknowns.start.innovation
        return Scatter(squares / (model.rows - model.parameters), 0.0, unknowns.start.chain)
    found = minimize(
        lambda vector: deviance_and_slopes(model, unknowns, vector, restricted=restricted),
        vector,
        jac=True,
        method="L-BFGS-B",
        bounds=unknowns.bounds,
        options={"ftol": TOLERANCE, "gtol": 1e-5, "maxiter": 200},
    )
    return unknowns.scatter(found.x)


def deviance_and_slopes(
    model: MixedModel, unknowns: Unknowns, vector: Array, *, restricted: bool
) -> tuple[float, Array]:
    solution = model.at(unknowns.scatter(vector))
    by_noise, by_group = solution.slopes(restricted=restricted)
    slopes = [] if unknowns.noise_known else [by_noise]
    if not unknowns.group_known:
        slopes.append(by_group * (solution.scatter.group + unknowns.unit))
    if unknowns.start.chain.order:
        by_gram = solution.slopes_by_gram(restricted=restricted)
        chains = range(len(slopes), vector.size)
        slopes += [_chain_slope(model, unknowns, vector, number, by_gram=by_gram) for number in chains]
    return solution.deviance(restricted=restricted), np.array(slopes)


def _chain_slope(model: MixedModel, unknowns: Unknowns, vector: Array, number: int, *, by_gram: Array) -> float:
    step = np.zeros(vector.size)
    step[number] = CHAIN_STEP
    (above, log_above), (below, log_below) = (
        model.whitened(unknowns.scatter(vector + sign * step)) for sign in (1, -1)
    )
    return (float(np.sum(by_gram * (above - below))) + log_above - log_below) / (2 * CHAIN_STEP)

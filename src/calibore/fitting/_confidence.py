"""How well a covariance is known that rests on an estimated scatter: Kenward and Roger (1997).

The information about the variances is the expected one, which stays sensible where no group error shows. The chains'
correlation is informed by the curvature of the deviance and taken as independent of them (Cox and Reid 1987).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._likelihood import CHAIN_STEP, Unknowns, deviance_and_slopes, variance_information
from calibore.fitting._mixed import Solution

Array = NDArray[Any]


class Confidence(NamedTuple):
    """`covariance` (p, p) with what the estimated variances add; `modes` (k, p, p): its standard deviations."""

    covariance: Array
    modes: Array


def confidence(solution: Solution, unknowns: Unknowns) -> Confidence:
    known = [unknowns.noise_known, unknowns.group_known]
    free = [i for i in (0, 1) if not known[i]]
    p, c = solution.model.parameters, solution.covariance
    covariance, modes = c, []
    if free:
        weights = np.linalg.inv(variance_information(solution)[np.ix_(free, free)])
        slopes, curvature = _variance_slopes(solution)
        slopes, curvature = slopes[free], curvature[np.ix_(free, free)]
        excess = curvature - np.einsum("iab,bc,jcd->ijad", slopes, c, slopes)
        covariance = c + 2 * c @ np.einsum("ij,ijab->ab", weights, excess) @ c
        modes.append(_modes(weights, -c @ slopes @ c))
    if unknowns.start.chain.order:
        modes.append(_chain_modes(solution, unknowns))
    return Confidence(covariance, np.concatenate(modes) if modes else np.zeros((0, p, p)))


def _modes(weights: Array, slopes: Array) -> Array:
    """Independent deviations of the covariance, of its `slopes` (k, p, p) by what has the covariance `weights`."""
    return np.tensordot(np.linalg.cholesky(weights).T, slopes, axes=1)


def _variance_slopes(solution: Solution) -> tuple[Array, Array]:
    """X' dV^-1 X (2, p, p) by the variances of noise and groups, and X' dV^-1 V dV^-1 X (2, 2, p, p)."""
    noise, group = solution.scatter.innovation, solution.scatter.group
    z, x = solution.groups, solution.parameters
    u, inner, whole = solution.weighed[z, x], solution.weighed[z, z], solution.data_information
    shared = u.T @ u
    by_noise = (whole - group * shared) / noise
    twice = (shared - group * u.T @ inner @ u) / noise
    return (
        np.array([-by_noise, -shared]),
        np.array([[(by_noise - group * twice) / noise, twice], [twice, u.T @ inner @ u]]),
    )


def _chain_modes(solution: Solution, unknowns: Unknowns) -> Array:
    model, vector = solution.model, unknowns.vector(solution.scatter)
    chains = range(vector.size - unknowns.start.chain.order, vector.size)
    rows, slopes = [], []
    for number in chains:
        step = np.zeros(vector.size)
        step[number] = CHAIN_STEP
        above, below = vector + step, vector - step
        change = [deviance_and_slopes(model, unknowns, v, restricted=True)[1] for v in (above, below)]
        rows.append((change[0] - change[1])[chains.start :] / (2 * CHAIN_STEP))
        spread = [model.at(unknowns.scatter(v)).covariance for v in (above, below)]
        slopes.append((spread[0] - spread[1]) / (2 * CHAIN_STEP))
    information, axes = np.linalg.eigh((np.array(rows) + np.array(rows).T) / 4)
    floor = 1e-3 * max(float(information.max()), 1.0)
    return np.tensordot((axes / np.sqrt(np.maximum(information, floor))).T, np.array(slopes), axes=1)

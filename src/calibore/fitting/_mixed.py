"""The linear mixed model: parameters, errors that groups share, correlated noise, and their restricted likelihood.

    r = X d + Z b + e,  b ~ N(0, group_variance 1),  e ~ N(0, innovation_variance R),  t = L d + N(0, 1)

X (n, p) Jacobian in a well-conditioned basis, Z (n, g) loads of the groups, R autoregressive along chains, (L, t) what
is known of the parameters before. P = V^-1 - V^-1 X C X' V^-1 below (Searle, Casella and McCulloch 1992, chapter 6).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._chains import Autoregression, LagMoments

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Scatter:
    """How residuals of sigma 1 scatter: variance of the `innovation` and of what a `group` shares; `chain`."""

    innovation: float
    group: float
    chain: Autoregression

    @property
    def noise(self) -> float:
        """Standard deviation of one residual of sigma 1, the groups' errors apart."""
        return float(np.sqrt(self.innovation * self.chain.variances[0]))


@dataclass(frozen=True, eq=False)
class MixedModel:
    """`moments` of the table [X Z r] (n, p + g + 1), columns of X first; prior rows `known` = [L t] (k, p + 1)."""

    moments: LagMoments
    parameters: int
    known: Array

    @property
    def rows(self) -> int:
        return self.moments.size

    def at(self, scatter: Scatter) -> "Solution":
        gram = self.moments.whitened(scatter.chain) / scatter.innovation
        log_noise = self.rows * float(np.log(scatter.innovation)) + self.moments.log_covariance(scatter.chain)
        return Solution(self, scatter, gram, log_noise)


@dataclass(frozen=True, eq=False)
class Solution:
    """The estimate for one `scatter`; `gram` (m, m) of the table, whitened but for the groups."""

    model: MixedModel
    scatter: Scatter
    gram: Array
    log_noise: float

    @property
    def parameters(self) -> slice:
        return slice(0, self.model.parameters)

    @property
    def groups(self) -> slice:
        return slice(self.model.parameters, -1)

    @cached_property
    def _core(self) -> Array:
        inner = self.gram[self.groups, self.groups]
        return np.linalg.inv(np.eye(len(inner)) + self.scatter.group * inner)

    @cached_property
    def weighed(self) -> Array:
        """[X Z r]' V^-1 [X Z r] of shape (m, m), V with the groups' errors (Woodbury)."""
        beside = self.gram[:, self.groups]
        return self.gram - self.scatter.group * beside @ self._core @ beside.T

    @cached_property
    def _prior(self) -> Array:
        return self.model.known.T @ self.model.known

    @cached_property
    def prior_information(self) -> Array:
        return self._prior[:-1, :-1]

    @cached_property
    def data_information(self) -> Array:
        return self.weighed[self.parameters, self.parameters]

    @cached_property
    def covariance(self) -> Array:
        """C (p, p) of the parameters, were the scatter known."""
        return np.linalg.inv(self.data_information + self.prior_information)

    @cached_property
    def step(self) -> Array:
        """Estimate d (p,)."""
        return self.covariance @ (self.weighed[self.parameters, -1] + self._prior[:-1, -1])

    @cached_property
    def left_of_groups(self) -> Array:
        """Z' P Z (g, g)."""
        beside = self.weighed[self.groups, self.parameters]
        return self.weighed[self.groups, self.groups] - beside @ self.covariance @ beside.T

    @cached_property
    def pull_of_groups(self) -> Array:
        """Z' P r (g,)."""
        return self.weighed[self.groups, -1] - self.weighed[self.groups, self.parameters] @ self.step

    @cached_property
    def group_errors(self) -> Array:
        """Best linear unbiased predictions (g,) of b."""
        return self.scatter.group * self.pull_of_groups

    @cached_property
    def squares(self) -> float:
        """Weighed sum r' P r of squares, of data and prior."""
        right = self.weighed[self.parameters, -1] + self._prior[:-1, -1]
        return float(self.weighed[-1, -1] + self._prior[-1, -1] - right @ self.step)

    def deviance(self, *, restricted: bool) -> float:
        """-2 log likelihood of data and prior, constants apart; `restricted` to what does not depend on parameters."""
        result = self.log_noise - np.linalg.slogdet(self._core)[1] + self.squares
        return float(result - np.linalg.slogdet(self.covariance)[1] if restricted else result)

    def slopes(self, *, restricted: bool) -> tuple[float, float]:
        """Derivatives of the deviance by the logarithm of the innovation's variance and by the groups' variance."""
        spread = self.left_of_groups if restricted else self.weighed[self.groups, self.groups]
        borne = np.trace(spread)
        pulled = self.pull_of_groups @ self.pull_of_groups
        count = self.model.rows - (self.free_parameters if restricted else 0.0)
        aside = self.model.known @ np.append(-self.step, 1.0)
        by_noise = count - self.scatter.group * (borne - pulled) - self.squares + aside @ aside
        return float(by_noise), float(borne - pulled)

    def slopes_by_gram(self, *, restricted: bool) -> Array:
        """Derivative (m, m) of the deviance by the Gram matrix of the whitened table."""
        turned = np.eye(len(self.gram))
        turned[self.groups] -= self.scatter.group * self._core @ self.gram[self.groups]
        left = turned[:, -1] - turned[:, self.parameters] @ self.step
        result = np.outer(left, left)
        result[self.groups, self.groups] += self.scatter.group * self._core
        return (
            result + turned[:, self.parameters] @ self.covariance @ turned[:, self.parameters].T
            if restricted
            else result
        )

    @cached_property
    def free_parameters(self) -> float:
        """Parameters that the data, not the prior, determine: p - tr(C L'L)."""
        return self.model.parameters - float(np.sum(self.covariance * self.prior_information))

"""Residuals made independent and of unit variance: neighbours first, then what groups share."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._mixed import Scatter
from calibore.fitting._problem import Problem, Rows

Array = NDArray[np.float64]


def whitening(rows: Rows, scatter: Scatter) -> Callable[[Array], Array]:
    """The map T with T V T' = 1, V the covariance of the residuals of sigma 1, for arrays (m, ...)."""
    filters = scatter.chain.whitener(rows.position) / np.sqrt(scatter.innovation)
    loads = filters @ rows.loads
    strength, axes = np.linalg.eigh((loads.T @ loads).toarray()) if loads.shape[1] else (np.zeros(0), np.eye(0))
    positive = strength > 0
    shrink = np.where(positive, (1 - 1 / np.sqrt(1 + scatter.group * strength)) / np.where(positive, strength, 1), 0)
    inner = (axes * shrink) @ axes.T
    return lambda values: (white := filters @ values) - loads @ (inner @ (loads.T @ white))


def whitened(problem: Problem, rows: Rows, scatter: Scatter) -> Callable[[Array], tuple[Array, Array]]:
    """Residuals and Jacobian, white, with the rows of the prior after them."""
    whiten = whitening(rows, scatter)

    def function(values: Array) -> tuple[Array, Array]:
        residuals, jacobian = problem.linearised(values, rows)
        aside = problem.aims - problem.known @ values
        return np.concatenate([whiten(residuals), aside]), np.concatenate([whiten(jacobian), problem.known])

    return function

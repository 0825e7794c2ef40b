"""What is fitted: a model, what is known of its residuals and of its parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]
Whole = NDArray[np.intp]
Mask = NDArray[np.bool_]
Model = Callable[[Array], tuple[Array, Array]]
Prior = tuple[Sequence[str], ArrayLike, ArrayLike]
"""Names, mean (k,) and covariance (k, k) of parameters known beforehand."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Residuals that are used, chain by chain: `index` (m,) in the model's order, `sigma` (m,), `position` (m,) in the
    chain, `loads` (m, g) sparse: what a unit of each group's error does to the residual of sigma 1.
    """

    index: Whole
    sigma: Array
    position: Whole
    loads: Any


@dataclass(frozen=True, eq=False)
class Problem:
    """`sigma` (n,), `group` (n,), `chain` (n,) with -1 of none, `load` (n,) of a group's error on the residual.

    `known` (k, p) and `aims` (k,): rows of the prior, of unit variance.
    """

    model: Model
    names: tuple[str, ...]
    sigma: Array
    group: Whole
    load: Array
    chain: Whole
    known: Array
    aims: Array

    @property
    def plain(self) -> bool:
        """Whether the scatter does not bear on the parameters."""
        return not self.aims.size and bool((self.group < 0).all() and (self.chain < 0).all())

    def linearised(self, values: Array, rows: Rows) -> tuple[Array, Array]:
        """Residuals (m,) of sigma 1 and their Jacobian (m, p)."""
        residuals, jacobian = self.model(values)
        return residuals[rows.index] / rows.sigma, jacobian[rows.index] / rows.sigma[:, None]

    def rows(self, used: Mask) -> Rows:
        from scipy.sparse import csr_array

        index = np.flatnonzero(used)
        chain = self.chain[index]
        index = index[np.argsort(chain, kind="stable")]
        group, sigma = self.group[index], self.sigma[index]
        shared = np.flatnonzero(group >= 0)
        loads = csr_array(
            (self.load[index[shared]] / sigma[shared], (shared, group[shared])),
            shape=(index.size, int(self.group.max(initial=-1)) + 1),
        )
        return Rows(index, sigma, _positions(self.chain[index]), loads)


def _numbered(group: Whole) -> Whole:
    """Groups as 0, 1, 2, ...; -1 of a group of one, which tells nothing about groups."""
    _, number, count = np.unique(group, return_inverse=True, return_counts=True)
    shares = (group >= 0) & (count[number] > 1)
    result = np.full(group.size, -1)
    result[shares] = np.unique(group[shares], return_inverse=True)[1]
    return result


def _positions(chain: Whole) -> Whole:
    """Place of each residual in its chain, of chains one after another; 0 of those in none."""
    count = np.arange(chain.size)
    starts = np.ones(chain.size, dtype=bool)
    starts[1:] = (chain[1:] != chain[:-1]) | (chain[1:] < 0)
    return count - np.maximum.accumulate(np.where(starts, count, 0))


def posed(
    model: Model,
    start: Array,
    names: Sequence[str],
    *,
    sigma: ArrayLike | None,
    prior: Prior | None,
    groups: ArrayLike | None,
    group_loads: ArrayLike | None,
    chains: ArrayLike | None,
) -> tuple[Problem, Mask]:
    """The problem, and which residuals are finite at `start`. Raises InputError where the arguments do not fit."""
    if start.shape != (len(names),) or not np.isfinite(start).all():
        raise InputError(f"A fit of {len(names)} parameters needs as many finite starting values, got {start}.")
    residuals, jacobian = model(start)
    n = residuals.size
    if residuals.shape != (n,) or jacobian.shape != (n, start.size):
        shapes = f"{residuals.shape} and {jacobian.shape}"
        raise InputError(f"The model must give residuals (n,) and their Jacobian (n, {start.size}), got {shapes}.")
    known, aims = _prior_rows(names, prior)
    problem = Problem(
        model=model,
        names=tuple(names),
        sigma=_per_residual("sigma", sigma, n, 1.0),
        group=_numbered(_labels("groups", groups, n)),
        load=_per_residual("group_loads", group_loads, n, 1.0),
        chain=_labels("chains", chains, n),
        known=known,
        aims=aims,
    )
    if not (problem.sigma > 0).all():
        raise InputError(
            f"sigma of residuals must be positive, got {problem.sigma.min():.6g}; leave it out if unknown."
        )
    return problem, np.isfinite(residuals) & np.isfinite(jacobian).all(axis=1)


def _prior_rows(names: Sequence[str], prior: Prior | None) -> tuple[Array, Array]:
    """Rows L and aims L mean such that L (values - mean) has unit variance."""
    if prior is None:
        return np.zeros((0, len(names))), np.zeros(0)
    subset, mean, matrix = prior[0], np.asarray(prior[1], dtype=float), np.asarray(prior[2], dtype=float)
    if missing := [name for name in subset if name not in names]:
        raise InputError(f"What is known beforehand names {missing[0]}, which is not fitted; leave it out.")
    if mean.shape != (len(subset),) or matrix.shape != (mean.size, mean.size):
        raise InputError(
            f"What is known of {len(subset)} parameters needs a mean and a square covariance of that size."
        )
    scale = np.sqrt(np.diag(matrix))
    try:
        root = np.linalg.inv(np.linalg.cholesky(matrix / np.outer(scale, scale))) / scale
    except np.linalg.LinAlgError:
        raise InputError(
            "The covariance of what is known beforehand is not positive definite; state an uncertainty of each."
        ) from None
    rows = np.zeros((mean.size, len(names)))
    rows[:, [list(names).index(name) for name in subset]] = root
    return rows, root @ mean


def _per_residual(what: str, values: ArrayLike | None, n: int, default: float) -> Array:
    values = np.asarray(default if values is None else values, dtype=float)
    if values.shape not in ((), (n,)) or not np.isfinite(values).all():
        raise InputError(f"{what} must be one finite number or one for each of the {n} residuals.")
    return np.broadcast_to(values, (n,))


def _labels(what: str, values: ArrayLike | None, n: int) -> Whole:
    labels = np.full(n, -1) if values is None else np.asarray(values)
    if labels.shape != (n,) or not np.issubdtype(labels.dtype, np.integer):
        raise InputError(f"{what} must be a whole number for each of the {n} residuals, -1 for none.")
    return labels.astype(np.intp)


def check_bounds(names: Sequence[str], values: Array, bounds: Mapping[str, tuple[float, float]]) -> None:
    """Raises InputError for the first parameter that is not inside its bounds."""
    for name, (low, high) in bounds.items():
        value = float(values[list(names).index(name)])
        if not low < value < high:
            raise InputError(
                f"The fit puts {name} at {value:.6g}, outside {low:.6g} to {high:.6g}: the data do not support this "
                "model; check what the marks were taken for, or add data."
            )

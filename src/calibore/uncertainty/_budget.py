"""Uncertainty budgets: which input contributes how much, to a point, over a ring, to a ring's mean."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.uncertainty._covariance import Covariance
from calibore.uncertainty._coverage import PROBABILITY, coverage_factor, effective_degrees_of_freedom
from calibore.uncertainty._distributions import Distribution
from calibore.uncertainty._propagation import matched
from calibore.uncertainty._scores import connected

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Budget:
    """The parts (q,) of the uncertainty of n results: the common inputs first, then the independent parts.

    `input_u` (q,) standard uncertainty of the inputs and `sensitivities` (n, q), both NaN for independent parts, which
    are known by their contribution alone; `contributions` (n, q) = |c| u; `variances` (n, q) = c_i (V c)_i with
    correlations, of either sign, which sum to u^2; `groups` (q,) equal labels for inputs correlated with each other.
    """

    names: tuple[str, ...]
    input_u: Array
    distributions: tuple[Distribution, ...]
    input_degrees_of_freedom: Array
    common: NDArray[np.bool_]
    groups: NDArray[np.intp]
    sensitivities: Array
    contributions: Array
    variances: Array

    @property
    def u(self) -> Array:
        """Combined standard uncertainty (n,)."""
        return np.sqrt(np.maximum(self.variances.sum(axis=1), 0.0))

    @property
    def u_common(self) -> Array:
        """Of the inputs that all results share (n,): a mean does not reduce it."""
        return np.sqrt(np.maximum(self.variances[:, self.common].sum(axis=1), 0.0))

    @property
    def u_independent(self) -> Array:
        """Of the parts that differ from result to result (n,)."""
        return np.sqrt(self.variances[:, ~self.common].sum(axis=1))

    @property
    def shares(self) -> Array:
        """Per cent of the variance (n, q), correlations included: they sum to 100 and may be negative."""
        total = self.variances.sum(axis=1, keepdims=True)
        return 100 * self.variances / np.where(total == 0, 1.0, total)

    @property
    def degrees_of_freedom(self) -> Array:
        """Effective (n,) by Welch-Satterthwaite; inputs correlated with each other count as one term.

        Such a term has the degrees of freedom of its calibration; where its members differ, the fewest.
        """
        labels = np.unique(self.groups)
        terms = np.stack([self.variances[:, self.groups == g].sum(axis=1) for g in labels], axis=1)
        nu = [self.input_degrees_of_freedom[self.groups == g].min() for g in labels]
        return effective_degrees_of_freedom(np.sqrt(np.maximum(terms, 0.0)), nu)

    def expanded(self, probability: float = PROBABILITY) -> Array:
        """Expanded uncertainty (n,) = Student's t of the effective degrees of freedom times u."""
        return coverage_factor(probability, self.degrees_of_freedom) * self.u

    def rms(self) -> "Budget":
        """One row: the root mean square over the results that exist, for a ring as a whole."""
        here = np.isfinite(self.variances).all(axis=1)
        if len(self.variances) == 1 or not here.any():
            return self._rows(slice(0, 1))
        return replace(
            self,
            sensitivities=np.sqrt(np.square(self.sensitivities[here]).mean(axis=0, keepdims=True)),
            contributions=np.sqrt(np.square(self.contributions[here]).mean(axis=0, keepdims=True)),
            variances=self.variances[here].mean(axis=0, keepdims=True),
        )

    def table(self, point: int | None = None) -> list[dict[str, str | float | bool | None]]:
        """Rows, the largest share first, of one result or (without `point`) of the rms; plain data fit for JSON.

        What is infinite (degrees of freedom) or not defined is None.
        """
        row = self.rms() if point is None else self._rows([point])
        shares = row.shares[0]
        order = np.argsort(-np.nan_to_num(shares), kind="stable")
        return [
            {
                "name": row.names[i],
                "u": _plain(row.input_u[i]),
                "distribution": str(row.distributions[i]),
                "degrees_of_freedom": _plain(row.input_degrees_of_freedom[i]),
                "sensitivity": _plain(row.sensitivities[0, i]),
                "contribution": _plain(row.contributions[0, i]),
                "share": _plain(shares[i]),
                "common": bool(row.common[i]),
            }
            for i in order
        ]

    def _rows(self, index: slice | list[int]) -> "Budget":
        return replace(
            self,
            sensitivities=self.sensitivities[index],
            contributions=self.contributions[index],
            variances=self.variances[index],
        )


def budget(
    sensitivities: ArrayLike,
    covariance: Covariance,
    *,
    names: Sequence[str] | None = None,
    independent: Mapping[str, ArrayLike] | None = None,
    degrees_of_freedom: Mapping[str, float] | None = None,
) -> Budget:
    """Of n results with `sensitivities` (n, p) to common inputs (columns as in `propagate`; (p,) is one result).

    `independent` are contributions |c| u (n,) by name that differ from result to result ("stripe"); their
    `degrees_of_freedom` are infinite where not given.
    """
    c = matched(np.atleast_2d(np.asarray(sensitivities, dtype=float)), covariance, names=names)
    extra = _independent(independent or {}, covariance, len(c))
    unknown = [name for name in degrees_of_freedom or {} if name not in extra]
    if unknown:
        raise InputError(f"No independent part is called {', '.join(unknown)}; present: {', '.join(extra) or 'none'}.")
    parts = np.stack([*extra.values()], axis=1) if extra else np.zeros((len(c), 0))
    k, p = parts.shape[1], len(covariance.names)
    nu = [*covariance.degrees_of_freedom, *((degrees_of_freedom or {}).get(name, inf) for name in extra)]
    return Budget(
        names=(*covariance.names, *extra),
        input_u=np.concatenate([covariance.u, np.full(k, np.nan)]),
        distributions=(*covariance.distributions, *([Distribution.NORMAL] * k)),
        input_degrees_of_freedom=np.array(nu, dtype=float),
        common=np.arange(p + k) < p,
        groups=np.concatenate([connected(covariance.matrix), np.arange(p, p + k)]),
        sensitivities=np.hstack([c, np.full_like(parts, np.nan)]),
        contributions=np.hstack([np.abs(c) * covariance.u, parts]),
        variances=np.hstack([c * (c @ covariance.matrix), parts**2]),
    )


def budget_of_mean(
    sensitivities: ArrayLike,
    covariance: Covariance,
    *,
    names: Sequence[str] | None = None,
    independent: Mapping[str, ArrayLike] | None = None,
    degrees_of_freedom: Mapping[str, float] | None = None,
    weights: ArrayLike | None = None,
    correlation: ArrayLike | None = None,
) -> Budget:
    """Of the mean of n results, arguments as in `budget`: one row. Independent parts average down, common ones do not.

    `weights` (n,), equal by default; `correlation` of the independent parts between results, (n, n) or the
    coefficients at lags 1, 2, ... round a closed ring. Results with NaN are left out.
    """
    each = budget(
        sensitivities, covariance, names=names, independent=independent, degrees_of_freedom=degrees_of_freedom
    )
    c, parts = each.sensitivities[:, each.common], each.contributions[:, ~each.common]
    w = np.ones(len(c)) if weights is None else np.array(weights, dtype=float)
    if w.shape != (len(c),):
        raise InputError(f"{len(c)} results need as many weights, got {w.size}.")
    here = np.isfinite(each.variances).all(axis=1) & np.isfinite(w)
    w = np.where(here, w, 0.0)
    if w.sum() == 0:
        raise InputError("A mean needs at least one result that exists, with a weight; none is left of them.")
    w /= w.sum()
    weighted = w[here, None] * parts[here]
    shared = _correlation(correlation, len(c))[np.ix_(here, here)] @ weighted if correlation is not None else weighted
    u = np.sqrt(np.maximum(np.einsum("nk,nk->k", weighted, shared), 0.0))
    return budget(
        w[here] @ c[here],
        covariance,
        independent={name: u[i] for i, name in enumerate(independent or {})},
        degrees_of_freedom=degrees_of_freedom,
    )


def _independent(given: Mapping[str, ArrayLike], covariance: Covariance, n: int) -> dict[str, Array]:
    parts: dict[str, Array] = {}
    for name, values in given.items():
        sizes = np.abs(np.asarray(values, dtype=float))
        if name in covariance.names:
            raise InputError(f"{name} is a common input already; give the independent part another name.")
        if sizes.shape not in ((), (1,), (n,)):
            raise InputError(f"The independent part {name} has shape {sizes.shape}, expected ({n},): one per result.")
        parts[name] = np.broadcast_to(sizes, (n,))
    return parts


def _correlation(given: ArrayLike, n: int) -> Array:
    values = np.atleast_1d(np.asarray(given, dtype=float))
    if np.abs(values).max(initial=0.0) > 1:
        raise InputError(f"Correlations lie between -1 and 1, got {values.flat[np.abs(values).argmax()]:g}.")
    if values.ndim == 1 and values.size <= n // 2:
        steps = np.abs(np.arange(n)[:, None] - np.arange(n))
        table = np.zeros(n)
        table[: values.size + 1] = [1.0, *values]
        return table[np.minimum(steps, n - steps)]
    if values.shape != (n, n):
        raise InputError(
            f"The correlation of {n} results has shape {(n, n)} or at most {n // 2} lags, got {values.shape}."
        )
    return values


def _plain(number: np.float64 | Array) -> float | None:
    return float(number) if np.isfinite(number) else None

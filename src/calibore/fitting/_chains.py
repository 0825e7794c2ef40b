"""Neighbours that resemble each other: autoregressive noise along chains.

A chain's noise follows x[t] = a1 x[t-1] + ... + aq x[t-q] + innovation, stated by its q partial autocorrelations
(each in -1..1, every choice is stationary). Its inverse covariance has a banded factor: whitening takes O(n q).
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Whole = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Autoregression:
    """`partial` autocorrelations (q,). `filters` (q + 1, q + 1): row t whitens the value at place t of a chain, the
    last row all later ones, column k that of k places before. `variances` (q + 1,): of a value given t before it,
    relative to the innovation; the first is that of the noise itself.
    """

    partial: Array
    filters: Array = field(init=False)
    variances: Array = field(init=False)

    def __post_init__(self) -> None:
        """Levinson and Durbin's recursion (Brockwell and Davis 1991, proposition 5.2.1)."""
        order = self.partial.size
        filters = np.zeros((order + 1, order + 1))
        filters[:, 0] = 1.0
        for t in range(1, order + 1):
            before = filters[t - 1, : t + 1]
            filters[t, : t + 1] = before - self.partial[t - 1] * before[::-1]
        variances = np.ones(order + 1)
        variances[:-1] = 1 / np.cumprod(1 - self.partial[::-1] ** 2)[::-1]
        object.__setattr__(self, "filters", filters / np.sqrt(variances)[:, None])
        object.__setattr__(self, "variances", variances)

    @property
    def order(self) -> int:
        return self.partial.size

    def correlation(self, lags: int) -> Array:
        """Autocorrelation (lags + 1,) at the lags 0, 1, 2, ..."""
        result = np.zeros(lags + 1)
        result[0] = 1.0
        weights = -self.filters * np.sqrt(self.variances)[:, None]
        for lag in range(1, lags + 1):
            reach = min(lag, self.order)
            result[lag] = weights[reach, 1 : reach + 1] @ result[lag - reach : lag][::-1]
        return result

    def whitener(self, position: Whole):
        """Banded factor W (n, n), sparse: W @ noise is white with the innovation's variance.

        `position` (n,) of each value in its chain, 0 for the first; chains stand one after another.
        """
        from scipy.sparse import csr_array

        place = np.minimum(position, self.order)
        lag = np.arange(self.order + 1)
        used = lag <= place[:, None]
        columns = np.arange(position.size)[:, None] - lag
        starts = np.concatenate([[0], np.cumsum(place + 1)])
        return csr_array((self.filters[place][used], columns[used], starts), shape=(position.size,) * 2)


WHITE = Autoregression(np.zeros(0))


@dataclass(frozen=True, eq=False)
class LagMoments:
    """Sums of products of the columns of `table` (n, m) at all pairs of lags up to `order`.

    With them `whitened(partial)`, the Gram matrix of the whitened table, costs O(q^2 m^2) whatever n is, but for the
    first values of each chain.
    """

    table: Array
    position: Whole
    order: int

    def whitened(self, autoregression: Autoregression) -> Array:
        """(W table)' (W table) of shape (m, m)."""
        if self.order == 0:
            return self._pairs[0]
        weights = autoregression.filters[-1]
        gram = np.tensordot(weights[self._first] * weights[self._second], self._pairs, axes=1)
        early = np.einsum("kn,knm->nm", autoregression.filters[self._place, :-1].T, self._early)
        return gram + early.T @ early

    def log_covariance(self, autoregression: Autoregression) -> float:
        """Logarithm of |covariance| of the noise with unit innovation."""
        return float(self._early_places @ np.log(autoregression.variances))

    @property
    def size(self) -> int:
        return self.position.size

    @cached_property
    def _early_places(self) -> Array:
        return np.bincount(self._place, minlength=self.order + 1).astype(float)

    def contracted(self, by_gram: Array) -> Array:
        """Tensor S (q + 1, q + 1, q + 1) with sum(by_gram * gram) = sum over t, j, k of S[t, j, k] f[t, j] f[t, k] for
        the filters f of any autoregression.
        """
        result = np.zeros((self.order + 1,) * 3)
        result[-1, self._first, self._second] = np.tensordot(self._pairs, by_gram, axes=2)
        turned = self._early @ by_gram
        for j in range(self.order):
            products = np.einsum("nm,knm->kn", turned[j], self._early)
            for k in range(self.order):
                result[:-1, j, k] = np.bincount(self._place, products[k], minlength=self.order)
        return result

    @cached_property
    def _first(self) -> Whole:
        return np.triu_indices(self.order + 1)[0]

    @cached_property
    def _second(self) -> Whole:
        return np.triu_indices(self.order + 1)[1]

    @cached_property
    def _starting(self) -> Whole:
        return np.flatnonzero(self.position < self.order)

    @cached_property
    def _place(self) -> Whole:
        return self.position[self._starting]

    @cached_property
    def _early(self) -> Array:
        """Rows (q, s, m) of the table 0, 1, 2, ... places before the first of each chain, 0 where there are none."""
        result = np.zeros((self.order, self._starting.size, self.table.shape[1]))
        for lag in range(self.order):
            there = self._place >= lag
            result[lag, there] = self.table[self._starting[there] - lag]
        return result

    @cached_property
    def _pairs(self) -> Array:
        """Moments (pairs, m, m) of lags j <= k over the values with `order` others before them, both ways round."""
        if self.order == 0:
            return (self.table.T @ self.table)[None]
        after = self._remaining
        whole = [self._product(np.flatnonzero(self.position >= lag), lag) for lag in range(self.order + 1)]
        edge = np.flatnonzero((self.position < self.order) | (after < self.order))
        moments = []
        for j, k in zip(self._first, self._second, strict=True):
            lag = k - j
            ends = (self.position[edge] >= lag) & ((self.position[edge] < self.order - j) | (after[edge] < j))
            moment = whole[lag] - self._product(edge[ends], lag)
            moments.append(moment if j == k else moment + moment.T)
        return np.array(moments)

    def _product(self, rows: Whole, lag: int) -> Array:
        return self.table[rows].T @ self.table[rows - lag]

    @cached_property
    def _remaining(self) -> Whole:
        """How many values of the chain come after each."""
        last = np.append(self.position[1:] == 0, True)
        ends = np.flatnonzero(last)
        return ends[np.searchsorted(ends, np.arange(self.position.size))] - np.arange(self.position.size)

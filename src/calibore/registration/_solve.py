"""The motion that makes residuals vanish on the whole, with the covariance of it and of what both profiles err by.

Unknowns are the free parameters of the motion, for each ring its drift where one is asked for, and the common modes of
both profiles with a prior N(0, 1). The estimating equation is that of least squares with Tukey's weights. Three things
make its covariance honest: noise in the slopes of the reference carries no information, so that part is taken away from
the information; residuals of neighbours are correlated as they turn out to be; and their scatter is the one observed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.registration._astray import AstrayError
from calibore.registration._gaps import Cloud, Gaps, gaps
from calibore.registration._motion import Motion
from calibore.registration._noise import design_effect, scores_covariance
from calibore.registration._robust import cost_of, scale_of, tukey
from calibore.registration._surface import Surface

Array = NDArray[np.float64]

STEPS = 60
SETTLED = 1e-2
"""Of the standard uncertainty: a smaller step changes nothing."""
DAMPED = 8
"""Steps after which every further one is taken by half: a motion that hops between two places then comes to rest."""
EVIDENT = 4.0
"""Standard deviations by which slopes must exceed their noise to tell anything."""
ALIKE = 64.0
"""Neighbouring positions whose slopes come from the same points."""
FEWEST = 30
"""Points that must lie on the reference."""


@dataclass(frozen=True, eq=False)
class Freedom:
    """What may move: `names` of the motion's parameters, their `prior` standard deviations (p,) about the start, and
    the `walk` (3,) by which roll [rad], shift in x and y [m] of a ring may differ from the next's; None: they do not.
    """

    names: tuple[str, ...]
    prior: Array
    walk: Array | None = None

    def only(self, names: tuple[str, ...]) -> "Freedom":
        """The same with fewer `names`."""
        return Freedom(names, np.array([self.prior[self.names.index(name)] for name in names]), self.walk)

    @property
    def columns(self) -> NDArray[np.intp]:
        return np.array([Motion.names.index(name) for name in self.names], dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Solution:
    """`motion`, `drift` (n, 3) of the moving rings, `modes` (q,) as estimated; joint `covariance` of free parameters,
    drifts ring by ring, and modes; the `gaps` there, robust `weights` (p,), `scatter` of residuals over what both
    profiles state, `correlation` (k,) of neighbours, `points` the number of independent ones they are worth;
    `cost` negative log likelihood of a point; `table` (p, s) slopes of the residuals by all that was solved for.
    """

    motion: Motion
    drift: Array | None
    modes: Array
    covariance: Array
    gaps: Gaps
    weights: Array
    scatter: float
    correlation: Array
    points: float
    cost: float
    table: Array


def solved(cloud: Cloud, surface: Surface, start: Motion, freedom: Freedom, *, about: Motion) -> Solution:
    """From a `start` near enough; priors are centred on `about`. Raises AstrayError where too few points count."""
    rings = int(cloud.ring.max()) + 1
    layout = _Layout(freedom, rings, len(cloud.modes) + len(surface.profile.common_mode))
    motion, state = start, np.zeros(layout.size)
    state[layout.motion] = (start.values - about.values)[freedom.columns]
    for number in range(STEPS):
        found = gaps(cloud, surface, motion, layout.drift(state))
        table = layout.table(found, cloud.ring)
        weights, scatter = _weights(found, state, table, layout)
        information, right = _normal(table, found, _left(found, state), weights, scatter)
        known = _known(information, layout, found, cloud, weights, scatter)
        # not by what is known: noise in slopes taken away, hardly any information may be left, and the step be huge
        step = np.linalg.solve(information + layout.prior, right - layout.prior @ state)
        state = state + step * (1.0 if number < DAMPED else 0.5)
        motion = about.with_values(_moved(about.values, freedom.columns, state[layout.motion]))
        if np.all(step**2 <= SETTLED**2 * np.diag(np.linalg.inv(known))):
            break
    return _solution(cloud, surface, layout, motion, state)


def _moved(values: Array, columns: NDArray[np.intp], change: Array) -> Array:
    values = values.copy()
    values[columns] += change
    return values


def _solution(cloud: Cloud, surface: Surface, layout: "_Layout", motion: Motion, state: Array) -> Solution:
    found = gaps(cloud, surface, motion, layout.drift(state))
    table = layout.table(found, cloud.ring)
    weights, scatter = _weights(found, state, table, layout)
    information, _ = _normal(table, found, _left(found, state), weights, scatter)
    known = _known(information, layout, found, cloud, weights, scatter)
    relative = _left(found, state) / (scatter * np.sqrt(found.total))
    correlation, effect = design_effect(relative, weights, cloud)
    root = weights / np.sqrt(found.total) / scatter  # squares of the scores, as Tukey's weights make them
    missed = np.nan_to_num(found.missed / np.sqrt(found.total))
    scores = scores_covariance(np.where(weights[:, None] > 0, table * root[:, None], 0.0), cloud, correlation, missed)
    inverse = np.linalg.inv(known)
    covariance = inverse @ (scores * effect + layout.prior) @ inverse
    worth = float(weights.sum() / (effect * (1 + 2 * correlation.sum())))
    usable = np.isfinite(found.residual) & np.isfinite(table).all(axis=1)
    cost = cost_of(_left(found, state)[usable], np.sqrt(found.total[usable]), scatter)
    drift, modes = layout.drift(state), state[layout.modes]
    return Solution(motion, drift, modes, covariance, found, weights, scatter, correlation, worth, cost, table)


def _left(found: Gaps, state: Array) -> Array:
    """Residuals (p,) without what common modes explain; those of the motion are in it already."""
    modes = len(found.modes)
    return found.residual + (found.modes.T @ state[state.size - modes :] if modes else 0.0)


def _weights(found: Gaps, state: Array, table: Array, layout: "_Layout") -> tuple[Array, float]:
    usable = np.isfinite(found.residual) & np.isfinite(table).all(axis=1)
    if np.count_nonzero(usable) < max(FEWEST, 2 * len(layout.freedom.names)):
        raise AstrayError(
            f"only {np.count_nonzero(usable)} of {usable.size} points of the moving profile lie on the reference"
        )
    relative = _left(found, state) / np.sqrt(found.total)
    scatter = scale_of(relative[usable])
    return np.where(usable, tukey(np.where(usable, relative, 0.0) / scatter), 0.0), scatter


def _normal(table: Array, found: Gaps, left: Array, weights: Array, scatter: float) -> tuple[Array, Array]:
    used = weights > 0
    root = np.sqrt(weights[used] / found.total[used]) / scatter
    rows = table[used] * root[:, None]
    return rows.T @ rows, -rows.T @ (left[used] * root)


def _known(information: Array, layout: "_Layout", found: Gaps, cloud: Cloud, weights: Array, scatter: float) -> Array:
    """(s, s) the information without what noise in slopes makes it look, with what was known before."""
    false = layout.false_information(found, cloud.ring, weights / (scatter**2 * found.total))
    return _positive(information - false) + layout.prior


def told(cloud: Cloud, surface: Surface, motion: Motion, names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the parameters `names` of which the wall's slopes tell more than their noise would by chance."""
    found = gaps(cloud, surface, motion)
    usable = np.isfinite(found.residual)
    weight = 1 / found.total[usable]
    kept = []
    for name in names:
        column = Motion.names.index(name)
        seen = np.sum(weight * found.jacobian[usable, column] ** 2)
        false = np.sum(weight * found.doubt[:, usable, column] ** 2)
        chance = 1 + EVIDENT * np.sqrt(2 * ALIKE / max(np.count_nonzero(usable), 1))
        if seen > chance * false:
            kept.append(name)
    return tuple(kept)


def _positive(matrix: Array) -> Array:
    """`matrix` (p, p) without directions of negative information."""
    scale = np.sqrt(np.maximum(np.diag(np.abs(matrix)), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    return (vectors * np.maximum(values, 0.0)) @ vectors.T * np.outer(scale, scale)


@dataclass(frozen=True, eq=False)
class _Layout:
    """Where each unknown stands: motion, drift of `rings` rings, `shared` modes."""

    freedom: Freedom
    rings: int
    shared: int

    @property
    def drifting(self) -> int:
        return 0 if self.freedom.walk is None else 3 * self.rings

    @property
    def size(self) -> int:
        return len(self.freedom.names) + self.drifting + self.shared

    @property
    def motion(self) -> slice:
        return slice(0, len(self.freedom.names))

    @property
    def modes(self) -> slice:
        return slice(self.size - self.shared, self.size)

    def drift(self, state: Array) -> Array | None:
        start = len(self.freedom.names)
        return state[start : start + self.drifting].reshape(self.rings, 3) if self.drifting else None

    def table(self, found: Gaps, ring: NDArray[np.intp]) -> Array:
        """(p, size) derivatives of the residuals."""
        parts = [found.jacobian[:, self.freedom.columns], self._of_drift(found.jacobian, ring), found.modes.T]
        return np.concatenate(parts, axis=1)

    def _of_drift(self, jacobian: Array, ring: NDArray[np.intp]) -> Array:
        own = np.zeros((len(jacobian), self.drifting))
        if self.drifting:
            rows = np.arange(len(jacobian))
            for k in range(3):
                own[rows, 3 * ring + k] = jacobian[:, k]
        return own

    def false_information(self, found: Gaps, ring: NDArray[np.intp], weight: Array) -> Array:
        """(size, size) what noise in slopes adds to the information."""
        total = np.zeros((self.size, self.size))
        end = self.size - self.shared
        for doubt in found.doubt:
            parts = [doubt[:, self.freedom.columns], self._of_drift(doubt, ring)]
            rows = np.concatenate(parts, axis=1)[weight > 0] * np.sqrt(weight[weight > 0])[:, None]
            total[:end, :end] += rows.T @ rows
        return total

    @property
    def prior(self) -> Array:
        """(size, size) information before any residual."""
        matrix = np.zeros((self.size, self.size))
        count = len(self.freedom.names)
        matrix[range(count), range(count)] = self.freedom.prior**-2.0
        matrix[range(self.size - self.shared, self.size), range(self.size - self.shared, self.size)] = 1.0
        if self.freedom.walk is not None:
            for k, step in enumerate(self.freedom.walk.tolist()):
                places = count + 3 * np.arange(self.rings) + k
                chain = np.diff(np.eye(self.rings), axis=0)
                # the mean of all drifts is the motion's own
                level = np.full((self.rings, self.rings), 1 / self.rings**2)
                matrix[np.ix_(places, places)] += (chain.T @ chain + level * self.rings) / step**2
        return matrix

"""A part of the pictures solved alone, in first order at the solution of all, and how its errors reach the solution."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Observations
from calibore.errors import InputError

Array = NDArray[Any]
LOST = 1e-9
"""Of the largest: directions in which half of the data tells nothing."""
HARDLY = 1e-3
"""Of a parameter: where residuals tell less, their scatter does not show in a covariance."""


class Solved(NamedTuple):
    """`change` (p,) of the parameters that a part of the residuals asks for; factors of its covariance: of errors its
    `own` (p, p), and `shared` (p, s) with every other part, column by column the same errors.
    """

    change: Array
    own: Array
    shared: Array


class HalvesData:
    """The residuals of `seen` and what they tell of the parameters `names` (p,); poses and errors of groups, of
    standard deviation `group_sigma`, are fitted beside. `known` (k, p): what was known of those parameters before.
    """

    def __init__(self, seen: Observations, names: list[str], group_sigma: float) -> None:
        self._names, self._used = names, seen.weight > 0
        weight = np.sqrt(seen.weight) / np.where(self._used, seen.sigma, 1.0)
        wanted = [seen.names.index(name) for name in names]
        jacobian = seen.jacobian * weight[:, None]
        load = weight * group_sigma * (1.0 if seen.load is None else seen.load)
        groups = _group_columns(seen.group, np.where(self._used, load, 0.0))
        self._wanted, self._residual = jacobian[:, wanted], seen.residual * weight
        self._beside = np.hstack([np.delete(jacobian, wanted, axis=1), groups])
        prior = np.zeros((0, len(seen.names) + 1)) if seen.prior is None else seen.prior
        of_groups = np.eye(self._beside.shape[1])[self._beside.shape[1] - groups.shape[1] :]
        blank = np.zeros((len(of_groups), len(names)))
        beside = np.delete(prior[:, :-1], wanted, axis=1)
        beside = np.hstack([beside, np.zeros((len(prior), groups.shape[1]))])
        self._shared = np.vstack([beside, of_groups]), np.vstack([prior[:, wanted], blank])
        self._aim = np.concatenate([prior[:, -1], np.zeros(len(of_groups))])
        self._of_names = self._shared[1].any(axis=1)

    @property
    def known(self) -> Array:
        return self._shared[1][self._of_names]

    def solved(self, chosen: NDArray[np.bool_], inflation: float) -> Solved:
        """By the residuals `chosen` (n,), which scatter `inflation` times as much as they say; factors in units of
        that. Raises InputError where they do not determine the parameters.
        """
        rows, scale = chosen & self._used, np.where(self._of_names, inflation, 1.0)
        gains = _gains(self._rows(rows, scale), self._names)
        count = int(rows.sum())
        change = gains @ np.concatenate([self._residual[rows], self._aim * scale])
        return Solved(change, np.asarray(np.linalg.qr(gains[:, :count].T, mode="r")).T, gains[:, count:])

    def inflation(self, stated: Array, in_image: Callable[[Array], Array]) -> float:
        """By how much residuals scatter more, for their neighbours' correlation, than their weights say: as a
        covariance C of factor `stated` (p, p) is larger than theirs in the image; where P was known of the camera
        before, by how many parameters they tell, for C^-1 = F / s^2 + P gives s^2 = tr(F C) / (p - tr(P C)).
        """
        if not self._of_names.any():
            whole = self.solved(self._used, 1.0)
            return _size(in_image(stated)) / _size(in_image(np.hstack([whole.own, whole.shared])))
        told = _size(self._rows(self._used, np.where(self._of_names, 0.0, 1.0)) @ stated) ** 2
        left = len(self._names) - _size(self.known @ stated) ** 2
        return float(np.sqrt(told / left)) if left > HARDLY else 1.0

    def _rows(self, chosen: NDArray[np.bool_], scale: Array) -> Array:
        """Jacobian (n + s, p) of the `chosen` residuals and of what they share with others, times `scale` (s,), less
        what all that is fitted beside explains of it.
        """
        beside, wanted = (shared * scale[:, None] for shared in self._shared)
        return _without(np.vstack([self._beside[chosen], beside]), np.vstack([self._wanted[chosen], wanted]))


def _group_columns(group: NDArray[np.intp], load: Array) -> Array:
    """(n, g): errors that groups share, in units of their standard deviation."""
    if not load.any():
        return np.zeros((group.size, 0))
    return (group[:, None] == np.unique(group[group >= 0])) * load[:, None]


def _without(left: Array, right: Array) -> Array:
    """`right` less what the columns of `left` explain, dependent ones included."""
    size = np.linalg.norm(left, axis=0)
    left = left[:, size > 0] / size[size > 0]
    if not left.shape[1]:
        return right
    basis, values, _ = np.linalg.svd(left, full_matrices=False)
    basis = basis[:, values > LOST * values[0]]
    return right - basis @ (basis.T @ right)


def _gains(jacobian: Array, names: list[str]) -> Array:
    """(p, n): what a unit of every row does to the parameters of least squares."""
    size = np.linalg.norm(jacobian, axis=0)
    left, values, turns = np.linalg.svd(jacobian / np.where(size > 0, size, 1.0), full_matrices=False)
    if not size.all() or values[-1] < LOST * values[0]:
        weak = names[int(np.argmin(size))] if not size.all() else names[int(np.argmax(np.abs(turns[-1])))]
        raise InputError(
            f"Half of the pictures does not determine {weak}, so one half cannot check the other; photograph the "
            "target at more places and tilts."
        )
    return turns.T / values / size[:, None] @ left.T


def _size(values: Array) -> float:
    return float(np.sqrt((values**2).sum()))

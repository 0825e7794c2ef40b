"""Camera and poses of all boards together: Levenberg-Marquardt with the poses eliminated board by board.

It searches, and compares models; the covariance of the chosen one comes from `fitting.least_squares`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._data import BoardData
from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.errors import InputError
from calibore.optics import Camera

Array = NDArray[np.float64]

STEPS = 200
SETTLED = 1e-9  # of the sum of squares
DAMPING = 1e-3, 1e10  # first, and where the search gives up
EASIER, HARDER = 0.2, 6.0
ROUNDING = 1e-13  # of the best known combination of parameters: below it nothing is known
CAUCHY = 3.0  # medians of the residuals at which a mark counts half in a robust search


@dataclass(frozen=True, eq=False)
class Estimate:
    """A `model` with `values` (p,) of `names`; `poses` (m, 6) and `bends` (3,) of the board as of `BoardData`;
    `residual` (n, 2) [px] measured minus predicted; whether the search `converged`.
    """

    model: LensModel
    values: Array
    poses: Array
    residual: Array
    size: tuple[int, int]
    bends: Array = field(default_factory=lambda: np.zeros(3))
    converged: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        return parameter_names(self.model)

    @cached_property
    def camera(self) -> Camera:
        return camera_of(self.model, self.values, self.size)

    def of_boards(self, boards: NDArray[np.bool_], data: BoardData) -> "Estimate":
        return replace(self, poses=self.poses[boards], residual=self.residual[boards[data.owner]])

    def with_camera_of(self, other: "Estimate") -> "Estimate":
        return replace(self, values=other.values, bends=other.bends)

    @property
    def square(self) -> Array:
        """Squared residual (n,) [px^2], mean of both coordinates."""
        return np.mean(self.residual**2, axis=1)

    @property
    def rms(self) -> float:
        """Of the residuals of one coordinate [px]."""
        return float(np.sqrt(self.square.mean()))


def parameter_names(model: LensModel) -> tuple[str, ...]:
    return (*model.parameters, ASPECT, *CENTRE)


def camera_of(model: LensModel, values: Sequence[float] | Array, size: tuple[int, int]) -> Camera:
    """Raises InputError for values that are no lens."""
    named = dict(zip(parameter_names(model), (float(value) for value in values), strict=True))
    return model.camera(named, width=size[0], height=size[1])


def bundle(
    data: BoardData,
    start: Estimate,
    *,
    free: Sequence[str] | None = None,
    robust: bool = False,
    steps: int = STEPS,
    settled: float = SETTLED,
) -> Estimate:
    """The least squares estimate near `start`.

    Parameters not in `free` are held (None: all are free, with the board's bends). `robust`: marks far off count little
    (Cauchy). It has converged when a step takes less than `settled` of the sum of squares. Raises InputError where the
    model does not image all marks at the start.
    """
    columns = [i for i, name in enumerate(start.names) if free is None or name in free]
    search = _Search(data, start, columns, bent=free is None and data.u_bend > 0, robust=robust)
    damping, converged = DAMPING[0], False
    for _ in range(steps):
        moved = search.tried(damping)
        if moved is None:
            damping *= HARDER
            if damping > DAMPING[1]:
                break
            continue
        damping = max(damping * EASIER, 1e-12)
        converged = search.cost - moved.cost <= settled * search.cost
        search.move(moved)
        if converged:
            break
    return replace(
        start,
        values=search.place.values,
        poses=search.place.poses,
        bends=search.place.bends,
        residual=search.place.scaled * data.sigma[:, None],
        converged=converged,
    )


def shared_covariance(data: BoardData, estimate: Estimate) -> Array:
    """Covariance (p, p) of `estimate.names`, poses and bends unknown too; white noise of the residuals' size."""
    search = _Search(data, estimate, list(range(len(estimate.names))), bent=data.u_bend > 0, robust=False)
    scaled, rows = search.place.scaled, search.told()
    size = np.linalg.norm(rows, axis=0)
    _, values, turns = np.linalg.svd(rows / size, full_matrices=False)
    factor = (turns.T / np.maximum(values, ROUNDING * values[0]) / size[:, None])[: len(estimate.names)]
    spare = max(scaled.size - len(estimate.names) - 6 * data.boards, 1)
    return factor @ factor.T * float(np.sum(scaled**2)) / spare


class _Place(NamedTuple):
    """A place of the search, and what is found there: residuals (n, 2) of sigma 1, their Jacobians by what all boards
    share and by poses, and the `cost`.
    """

    values: Array
    bends: Array
    poses: Array
    scaled: Array
    by_shared: Array
    by_pose: Array
    cost: float


class _Search:
    """Normal equations at the present `place`."""

    def __init__(self, data: BoardData, start: Estimate, columns: list[int], *, bent: bool, robust: bool) -> None:
        self._data, self._start, self._columns, self._bent = data, start, columns, bent
        self._limit = np.inf
        place = self._at(start.values, start.bends, start.poses)
        if place is None:
            raise InputError(f"{start.model.name} does not image all marks.")
        if robust:
            self._limit = CAUCHY * float(np.median(np.hypot(*place.scaled.T)))
            place = place._replace(cost=self._cost(place.scaled, place.bends))
        self.move(place)

    @property
    def cost(self) -> float:
        return self.place.cost

    def move(self, place: _Place) -> None:
        """Go there and prepare the normal equations."""
        self.place = place
        scaled, shared, pose, data = place.scaled, place.by_shared, place.by_pose, self._data
        weight = 1 / (1 + np.sum(scaled**2, axis=1) / self._limit**2)
        weighted = pose * weight[:, None, None]
        self._shared = np.einsum("n,nci,ncj->ij", weight, shared, shared, optimize=True)
        self._mixed = data.sums(shared.transpose(0, 2, 1) @ weighted)
        self._pose = data.sums(pose.transpose(0, 2, 1) @ weighted)
        self._towards_shared = np.einsum("n,nci,nc->i", weight, shared, scaled)
        self._towards_pose = data.sums(np.einsum("nci,nc->ni", weighted, scaled))
        if self._bent:
            self._shared[-3:, -3:] += np.eye(3) / data.u_bend**2
            self._towards_shared[-3:] -= place.bends / data.u_bend**2

    def told(self) -> Array:
        """What the marks tell of the shared parameters (r, p) once each board's pose has taken its share."""
        data, rows = self._data, []
        for start, end in zip(data.starts, [*data.starts[1:], data.owner.size], strict=True):
            pose = self.place.by_pose[start:end].reshape(-1, 6)
            shared = self.place.by_shared[start:end].reshape(len(pose), -1)
            turn = np.linalg.qr(pose / np.linalg.norm(pose, axis=0))[0]
            rows.append(shared - turn @ (turn.T @ shared))
        if self._bent:
            rows.append(np.eye(3, rows[0].shape[1], rows[0].shape[1] - 3) / data.u_bend)
        return np.concatenate(rows)

    def tried(self, damping: float) -> _Place | None:
        """Where a damped step leads; None where it leads no further down."""
        pose = self._pose + damping * _diagonal(self._pose)
        shared = self._shared + damping * _diagonal(self._shared[None])[0]
        sides = np.concatenate([self._mixed.transpose(0, 2, 1), self._towards_pose[..., None]], axis=2)
        try:
            solved = np.linalg.solve(pose, sides)
            by_shared, towards = solved[..., :-1], solved[..., -1]
            reduced = shared - np.einsum("mip,mpj->ij", self._mixed, by_shared)
            step = np.linalg.solve(reduced, self._towards_shared - np.einsum("mip,mp->i", self._mixed, towards))
        except np.linalg.LinAlgError:
            return None
        values = self.place.values.copy()
        values[self._columns] += step[: len(self._columns)]
        bends = self.place.bends + step[-3:] if self._bent else self.place.bends
        place = self._at(values, bends, self.place.poses + towards - by_shared @ step)
        return place if place is not None and place.cost <= self.cost else None

    def _cost(self, scaled: Array, bends: Array) -> float:
        square = np.sum(scaled**2, axis=1)
        prior = float(bends @ bends) / self._data.u_bend**2 if self._bent else 0.0
        return prior + float(
            np.sum(self._limit**2 * np.log1p(square / self._limit**2) if self._limit < np.inf else square)
        )

    def _at(self, values: Array, bends: Array, poses: Array) -> _Place | None:
        """None where marks are not imaged."""
        start = self._start
        try:
            camera = camera_of(start.model, values, start.size)
        except InputError:
            return None
        with np.errstate(all="ignore"):
            found = self._data.predicted(camera, poses, bends)
        index = [camera.parameter_names.index(start.names[i]) for i in self._columns]
        shared = [found.by_camera[:, :, index], found.by_bend] if self._bent else [found.by_camera[:, :, index]]
        sigma = self._data.sigma[:, None, None]
        by_shared, by_pose = np.concatenate(shared, axis=2) / sigma, found.by_pose / sigma
        if not all(np.isfinite(part).all() for part in (found.pixel, by_shared, by_pose)):
            return None
        scaled = (self._data.pixel - found.pixel) / sigma[..., 0]
        return _Place(values, bends, poses, scaled, by_shared, by_pose, self._cost(scaled, bends))


def _diagonal(matrices: Array) -> Array:
    """The diagonals of (m, p, p), a little more than nothing where they vanish."""
    diagonal = np.einsum("mii->mi", matrices)
    return np.einsum("mi,ij->mij", np.maximum(diagonal, 1e-12), np.eye(matrices.shape[1]))

"""Camera and poses of all boards together: Levenberg-Marquardt with the poses eliminated board by board.

It searches, and compares models; the covariance of the chosen one comes from `fitting.least_squares`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards_data import BoardData
from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.errors import InputError
from calibore.optics import Camera

Array = NDArray[np.float64]

STEPS = 200
SETTLED = 1e-10  # of the sum of squares
DAMPING = 1e-3, 1e10  # first, and where the search gives up
EASIER, HARDER = 0.2, 6.0
CAUCHY = 3.0  # medians of the residuals at which a mark counts half in a robust search


@dataclass(frozen=True, eq=False)
class Estimate:
    """A `model` with `values` (p,) of `names`, `poses` (m, 6) of the boards as of `BoardData.predicted`; `residual`
    (n, 2) [px] measured minus predicted; whether the search `converged`.
    """

    model: LensModel
    values: Array
    poses: Array
    residual: Array
    size: tuple[int, int]
    converged: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        return parameter_names(self.model)

    @cached_property
    def camera(self) -> Camera:
        return camera_of(self.model, self.values, self.size)

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
    """The least squares estimate near `start`; parameters not in `free` (None: all) are held. `robust`: marks far off
    count little (Cauchy). It has converged when a step takes less than `settled` of the sum of squares. Raises InputError where the model does not image all marks at the start.
    """
    columns = [i for i, name in enumerate(start.names) if free is None or name in free]
    search = _Search(data, start, columns, robust)
    damping, converged = DAMPING[0], False
    for _ in range(steps):
        moved = search.tried(damping)
        if moved is None:
            damping *= HARDER
            if damping > DAMPING[1]:
                break
            continue
        damping = max(damping * EASIER, 1e-12)
        converged = search.cost - moved[0] <= settled * search.cost
        search.move(*moved)
        if converged:
            break
    return replace(start, values=search.values, poses=search.poses, residual=search.residual, converged=converged)


class _Search:
    def __init__(self, data: BoardData, start: Estimate, columns: list[int], robust: bool) -> None:
        self._data, self._start, self._columns = data, start, columns
        self._limit, self._robust = np.inf, robust
        self.values, self.poses = start.values, start.poses
        found = self._evaluated(start.values, start.poses)
        if found is None:
            raise InputError(f"{start.model.name} does not image all marks.")
        if robust:
            self._limit = CAUCHY * float(np.median(np.hypot(*found[0].T)))
        self.move(self._cost(found[0]), start.values, start.poses, found)

    def move(self, cost: float, values: Array, poses: Array, found: tuple[Array, Array, Array]) -> None:
        """Go to a place and prepare the normal equations there."""
        self.cost, self.values, self.poses = cost, values, poses
        scaled, by_camera, by_pose = found
        self.residual = scaled * self._data.sigma[:, None]
        weight = 1 / (1 + np.sum(scaled**2, axis=1) / self._limit**2)
        weighted = by_pose * weight[:, None, None]
        self._camera = np.einsum("n,nci,ncj->ij", weight, by_camera, by_camera)
        self._mixed = self._data.sums(np.einsum("nci,ncj->nij", by_camera, weighted))
        self._pose = self._data.sums(np.einsum("nci,ncj->nij", by_pose, weighted))
        self._towards_camera = np.einsum("n,nci,nc->i", weight, by_camera, scaled)
        self._towards_pose = self._data.sums(np.einsum("nci,nc->ni", weighted, scaled))

    def tried(self, damping: float) -> tuple[float, Array, Array, tuple[Array, Array, Array]] | None:
        """Cost and place after a damped step; None where it leads no further down."""
        pose = self._pose + damping * _diagonal(self._pose)
        camera = self._camera + damping * _diagonal(self._camera[None])[0]
        try:
            solved = np.linalg.solve(pose, np.concatenate([self._mixed.transpose(0, 2, 1), self._towards_pose[..., None]], 2))
            by_camera, towards = solved[..., :-1], solved[..., -1]
            reduced = camera - np.einsum("mip,mpj->ij", self._mixed, by_camera)
            right = self._towards_camera - np.einsum("mip,mp->i", self._mixed, towards)
            step = np.linalg.solve(reduced, right)
        except np.linalg.LinAlgError:
            return None
        values = self.values.copy()
        values[self._columns] += step
        poses = self.poses + towards - by_camera @ step
        found = self._evaluated(values, poses)
        if found is None:
            return None
        cost = self._cost(found[0])
        return (cost, values, poses, found) if cost <= self.cost else None

    def _cost(self, scaled: Array) -> float:
        square = np.sum(scaled**2, axis=1)
        return float(self._limit**2 * np.log1p(square / self._limit**2).sum() if self._robust else square.sum())

    def _evaluated(self, values: Array, poses: Array) -> tuple[Array, Array, Array] | None:
        """Residuals (n, 2) of sigma 1, their Jacobians by the free parameters and by poses; None: not imaged."""
        start = self._start
        try:
            camera = camera_of(start.model, values, start.size)
        except InputError:
            return None
        with np.errstate(all="ignore"):
            found = self._data.predicted(camera, poses)
        if not np.isfinite(found.pixel).all():
            return None
        index = [camera.parameter_names.index(start.names[i]) for i in self._columns]
        sigma = self._data.sigma[:, None]
        by_camera, by_pose = found.by_camera[:, :, index] / sigma[..., None], found.by_pose / sigma[..., None]
        if not (np.isfinite(by_camera).all() and np.isfinite(by_pose).all()):
            return None
        return (self._data.pixel - found.pixel) / sigma, by_camera, by_pose


def _diagonal(matrices: Array) -> Array:
    """The diagonals of (m, p, p), a little more than nothing where they vanish."""
    diagonal = np.einsum("mii->mi", matrices)
    return np.einsum("mi,ij->mij", np.maximum(diagonal, 1e-12), np.eye(matrices.shape[1]))

"""The chosen model with all poses at once: values and the covariance that counts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate, camera_of
from calibore.calibration._boards._data import BoardData
from calibore.errors import InputError
from calibore.fitting import Fit, least_squares

Array = NDArray[np.float64]

BENDS = ("board.bend_along", "board.bend_down", "board.twist")
POSE = ("rotation_x", "rotation_y", "rotation_z", "x", "y", "z")


@dataclass(frozen=True, eq=False)
class BoardFit:
    """`fit` of residuals u, v, u, v, ... of `data`, all parameters named; `estimate` at its values."""

    data: BoardData
    estimate: Estimate
    fit: Fit

    @property
    def camera_names(self) -> tuple[str, ...]:
        return self.estimate.names

    @property
    def covariance(self) -> Array:
        """Of `camera_names` (p, p)."""
        p = len(self.camera_names)
        return self.fit.covariance[:p, :p]

    def u(self, name: str) -> float:
        return float(self.fit.u[self.fit.names.index(name)])


def fit_boards(data: BoardData, estimate: Estimate, *, neighbours: bool = True) -> BoardFit:
    """`neighbours`: marks of a row may share errors (of lens, print or finding); how much, their residuals tell. Raises
    InputError where the fit fails.
    """
    p, bent = len(estimate.names), data.u_bend > 0
    names = (*estimate.names, *(BENDS if bent else ()), *pose_names(data.boards))
    start = np.concatenate([estimate.values, estimate.bends if bent else [], estimate.poses.ravel()])
    first_pose = p + 3 * bent

    def parts(values: Array) -> tuple[Array, Array, Array]:
        bends = values[p:first_pose] if bent else np.zeros(3)
        return values[:p], bends, values[first_pose:].reshape(-1, 6)

    def model(values: Array) -> tuple[Array, Array]:
        camera_values, bends, poses = parts(values)
        try:
            camera = camera_of(estimate.model, camera_values, data.size)
        except InputError:
            return np.full(data.pixel.size, np.nan), np.full((data.pixel.size, values.size), np.nan)
        found = data.predicted(camera, poses, bends)
        index = [camera.parameter_names.index(name) for name in estimate.names]
        jacobian = np.zeros((len(data.pixel), 2, values.size))
        jacobian[:, :, :p] = found.by_camera[:, :, index]
        if bent:
            jacobian[:, :, p:first_pose] = found.by_bend
        columns = first_pose + 6 * data.owner[:, None] + np.arange(6)
        np.put_along_axis(jacobian, np.broadcast_to(columns[:, None], found.by_pose.shape), found.by_pose, axis=2)
        return (data.pixel - found.pixel).ravel(), jacobian.reshape(-1, values.size)

    sigma = np.repeat(data.sigma / np.median(data.sigma), 2)
    prior = (BENDS, np.zeros(3), np.eye(3) * data.u_bend**2) if bent else None
    chains = _rows(data) if neighbours else None
    fit = least_squares(model, start, names=names, sigma=sigma, prior=prior, chains=chains)
    camera_values, bends, poses = parts(fit.values)
    found = Estimate(estimate.model, camera_values, poses, fit.residuals.reshape(-1, 2), data.size, bends)
    return BoardFit(data, found, fit)


def _rows(data: BoardData) -> NDArray[np.intp]:
    """For each residual the row of a board that its mark stands in, u apart from v."""
    changes = (np.diff(data.owner, prepend=-1) != 0) | (np.diff(data.place[:, 1], prepend=np.nan) != 0)
    row = np.cumsum(changes)
    return np.stack([2 * row, 2 * row + 1], axis=1).ravel()


def pose_names(boards: int) -> tuple[str, ...]:
    """Dotted paths of all poses: rotation vector [rad] and place [m] of the board's middle in the camera frame."""
    return tuple(f"board.{number}.{name}" for number in range(boards) for name in POSE)

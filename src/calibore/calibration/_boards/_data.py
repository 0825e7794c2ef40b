"""Marks of all boards as one table, and where a camera images them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from calibore.optics import Camera
from calibore.targets import BoardMarks

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Whole = NDArray[np.intp]

LEAST_SIGMA = 0.5
"""Of the median: no mark is much better than most, whatever the noise of its few pixels says."""


class Prediction(NamedTuple):
    """Pixels (n, 2), their derivatives by the camera's parameters (n, 2, p), by the pose of the board (n, 2, 6) and by
    its bends (n, 2, 3); NaN where the camera images nothing.
    """

    pixel: Array
    by_camera: Array
    by_pose: Array
    by_bend: Array


@dataclass(frozen=True, eq=False)
class BoardData:
    """`pixel` (n, 2) [px] of marks at `place` (n, 3) [m] on the board of picture `owner` (n,), which counts the boards
    in order from 0 and does not decrease; `sigma` (n,) [px] of each coordinate, up to a common factor; image `size`;
    `extent` [m] from the middle of the board to the outermost marks along x and y.

    One board, on all pictures: it rises out of its plane by `bends @ shapes`; `u_bend` [m]: standard uncertainty of
    each of the three bends before any picture, 0 where it is flat.
    """

    pixel: Array
    place: Array
    sigma: Array
    owner: Whole
    size: tuple[int, int]
    extent: tuple[float, float]
    u_bend: float = 0.0

    @classmethod
    def of(cls, marks: Sequence[BoardMarks], *, square: float, size: tuple[int, int], u_bend: float = 0.0) -> Self:
        """Places are counted from the middle of all marks, so that a board turns about itself."""
        place = np.concatenate([np.stack([m.x, m.y, 0 * m.x], axis=1) for m in marks]) * square
        place -= (place.max(axis=0) + place.min(axis=0)) / 2
        extent = float(place[:, 0].max()), float(place[:, 1].max())
        sigma = np.concatenate([np.full(m.u.shape, m.sigma) if m.sigmas is None else m.sigmas for m in marks])
        pixel = np.concatenate([np.stack([m.u, m.v], axis=1) for m in marks])
        owner = np.repeat(np.arange(len(marks)), [m.u.size for m in marks])
        return cls(pixel, place, np.maximum(sigma, LEAST_SIGMA * np.median(sigma)), owner, size, extent, u_bend)

    @property
    def boards(self) -> int:
        return int(self.owner[-1]) + 1

    @cached_property
    def starts(self) -> Whole:
        """Index (m,) of the first mark of each board."""
        return np.flatnonzero(np.diff(self.owner, prepend=-1))

    def only(self, marks: Mask) -> "BoardData":
        """With some of the marks (n,); boards are counted anew."""
        owner = np.unique(self.owner[marks], return_inverse=True)[1]
        return replace(self, pixel=self.pixel[marks], place=self.place[marks], sigma=self.sigma[marks], owner=owner)

    def of_boards(self, boards: Mask) -> "BoardData":
        return self.only(boards[self.owner])

    def sums(self, values: Array) -> Array:
        """`values` (n, ...) added up board by board: (m, ...)."""
        return np.add.reduceat(values, self.starts, axis=0)

    @cached_property
    def shapes(self) -> Array:
        """Rise (n, 3) per unit of bend: along the rows, down the columns, twisted; 1 at the middles of the sides."""
        x, y = (self.place[:, :2] / self.extent).T
        return np.stack([x * x, y * y, x * y], axis=1)

    def points(self, poses: Array, bends: Array | None = None) -> tuple[Array, Array]:
        """Points (n, 3) of the camera frame for `poses` (m, 6), and their offsets from the middle of the board."""
        offset = self._turned(rotations(poses[:, :3]), bends)
        return offset + poses[self.owner, 3:], offset

    def _turned(self, rotation: Array, bends: Array | None) -> Array:
        place = self.place if bends is None else self.place + np.outer(self.shapes @ bends, [0.0, 0.0, 1.0])
        return (rotation[self.owner] @ place[:, :, None])[:, :, 0]

    def predicted(self, camera: Camera, poses: Array, bends: Array) -> Prediction:
        """Where `camera` images the marks of boards at `poses` (m, 6): rotation vector [rad], place [m]."""
        rotation, owner = rotations(poses[:, :3]), self.owner
        offset = self._turned(rotation, bends)
        image = camera.project_with_sensitivities(offset + poses[owner, 3:])
        turned = image.by_point @ -_skew(offset) @ _left_jacobians(poses[:, :3])[owner]
        by_bend = image.by_point @ rotation[owner, :, 2:] * self.shapes[:, None, :]
        by_pose = np.concatenate([turned, image.by_point], axis=2)
        return Prediction(np.stack([image.u, image.v], axis=1), image.by_parameters, by_pose, by_bend)


def rotations(vectors: Array) -> Array:
    """Rotation matrices (m, 3, 3) of rotation vectors (m, 3) [rad] (Rodrigues)."""
    cross, sine, versine, _ = _series(vectors)
    return np.eye(3) + sine * cross + versine * cross @ cross


def rotation_vectors(matrices: Array) -> Array:
    """Rotation vectors (m, 3) [rad] of rotation matrices (m, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(matrices).as_rotvec()


def _left_jacobians(vectors: Array) -> Array:
    """(m, 3, 3): exp(w + dw) is exp(J dw) exp(w) in first order."""
    cross, _, versine, cubic = _series(vectors)
    return np.eye(3) + versine * cross + cubic * cross @ cross


def _series(vectors: Array) -> tuple[Array, Array, Array, Array]:
    """[w]x, and sin a / a, (1 - cos a) / a^2, (a - sin a) / a^3 of the angle a, each (m, 1, 1)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    small = angle < 1e-4  # where the next term of the series is below rounding
    safe = np.where(small, 1.0, angle)
    sine = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    versine = np.where(small, 0.5 - angle**2 / 24, 2 * (np.sin(safe / 2) / safe) ** 2)
    cubic = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    return _skew(vectors), sine, versine, cubic


def _skew(vectors: Array) -> Array:
    """(n, 3, 3) with `skew(a) @ b = a x b`."""
    matrix = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrix[:, 0, 1], matrix[:, 0, 2], matrix[:, 1, 2] = -z, y, -x
    matrix[:, 1, 0], matrix[:, 2, 0], matrix[:, 2, 1] = z, -y, x
    return matrix

"""Photographs of a flat board held before a camera: chessboard, ChArUco or dots."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera
from calibore.simulation._board_target import photograph_board
from calibore.simulation._sensor import Sensor
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres
from calibore.simulation._targets._values import camera_values
from calibore.targets import Board

Array = NDArray[np.float64]
MARGIN = 12.0  # px from the picture's border
SEEN = (8.0, 24.0)  # deg: half of the board's diagonal, as seen by the camera
TRIES = 10_000


@dataclass(frozen=True, eq=False)
class BoardTarget(Target):
    """`board` with squares (or pitches) of truly `square` [m], held before `camera` at `poses` (camera_from_board).

    target.toml states `stated_square` [m], the true one where None, and that the board is flat.
    """

    camera: Camera
    board: Board
    square: float
    poses: Sequence[Pose]
    stated_square: float | None = None
    sensor: Sensor = field(default_factory=lambda: Sensor(psf_sigma=0.9))
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "lens"

    def __post_init__(self) -> None:
        if not self.poses or self.square <= 0:
            raise InputError(f"A board needs poses and a positive square, got {len(self.poses)}, {self.square:g} m.")

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Nothing is left to chance but the pictures."""
        del rng
        board, square = self.board, self.stated_square or self.square
        named = {f"board {number:03d}.png": partial(self._photograph, pose) for number, pose in enumerate(self.poses)}
        return Layout(
            said={
                "kind": board.kind,
                "images": "board *.png",
                "square": metres(square),
                "corners": list(board.corners),
                "marker": metres(board.marker * square) if board.kind == "charuco" else None,
                "dictionary": board.dictionary if board.kind == "charuco" else None,
                "dot": metres(board.dot * square) if board.has_dots else None,
                "flatness": "0 mm",
            },
            truth={
                **camera_values(self.camera),
                "pose_R": np.stack([pose.rotation for pose in self.poses]),
                "pose_t_m": np.stack([pose.translation for pose in self.poses]),
                "square": self.square,
            },
            pictures=named,
        )

    def _photograph(self, pose: Pose, rng: np.random.Generator) -> np.ndarray:
        board = self.board
        return photograph_board(
            self.camera,
            pose,
            kind=board.kind,
            corners=board.corners,
            square=self.square,
            marker=board.marker,
            dictionary=board.dictionary,
            dot=board.dot,
            sensor=self.sensor,
            rng=rng,
        )


def held_boards(
    camera: Camera,
    board: Board,
    *,
    square: float,
    count: int,
    rng: np.random.Generator,
    tilt: float = 0.7,
    margin: float = MARGIN,
) -> list[Pose]:
    """Poses (camera_from_board) of `count` boards wholly in the picture, `margin` [px] from its border, by chance:
    facing the camera but for up to `tilt` [rad]. Raises InputError where none fits.
    """
    points = np.column_stack([board.places * square, np.zeros(len(board.places))])
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    found: list[Pose] = []
    for _ in range(TRIES):
        if len(found) == count:
            return found
        u, v = rng.uniform(0.08, 0.92, 2) * (camera.width, camera.height)
        towards = camera.unproject([u], [v]).direction[0]
        if not np.isfinite(towards).all():
            continue
        rotation = _facing(towards) @ _tilted(rng, tilt)
        distance = np.linalg.norm(middle) / np.tan(np.radians(rng.uniform(*SEEN)))
        pose = Pose(rotation, towards * distance - rotation @ middle)
        if _inside(camera, pose, points, margin):
            found.append(pose)
    raise InputError(f"Only {len(found)} of {count} boards fit into the picture; use a smaller board or wider lens.")


def _facing(towards: Array) -> Array:
    """Rotation (3, 3) of a board whose z points along the unit vector `towards`."""
    x = np.cross([0.0, 1.0, 0.0], towards)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(towards, x), towards], axis=1)


def _tilted(rng: np.random.Generator, tilt: float) -> Array:
    """A turn about some axis in the board by up to `tilt` [rad], after one in its plane."""
    angle, way, roll = rng.uniform(0, tilt), *rng.uniform(0, 2 * np.pi, 2)
    axis = np.array([np.cos(way), np.sin(way), 0.0])
    cross = np.cross(np.eye(3), axis)
    lean = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return lean @ Pose.from_roll_pitch_yaw(roll).rotation


def _inside(camera: Camera, pose: Pose, points: Array, margin: float) -> bool:
    u, v = camera.project(pose.apply(points))
    return bool(
        np.isfinite(u).all()
        and min(u.min(), v.min()) > margin
        and u.max() < camera.width - 1 - margin
        and v.max() < camera.height - 1 - margin
    )

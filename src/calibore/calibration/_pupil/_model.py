"""Two upright pins seen by a camera that turns about a pivot: where their axes appear.

Frame of the fixture: origin on the pivot, y down along it, z along the slide when the turntable reads 0, x to the right
of the camera. Turned by `turn`, the entrance pupil stands at T(turn) (offset, 0, pupil - slide).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import middle_of
from calibore.optics import Camera, Lens

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

PUPIL, K = "pupil.slide", "camera.k"
CAMERA = ("camera.yaw", "camera.pitch", "camera.roll")
OFFSET = "pivot.offset"
PIN = ("x", "z", "lean_x", "lean_z")
SLIDE, TURN = "slide.", "turn."
"""A slide's reading [m]; what the turntable really turned beyond its reading [rad]."""
FIRST_SLIDE = 14
NEWTON_STEPS = 2
"""From a mark to where the model sees the axis in its row: pictures are smooth, two steps would do."""


@dataclass(frozen=True, eq=False)
class Sightings:
    """n marks on the axes of the pins: `u`, `v`, `sigma`, `half_width` (n,) [px], `near` (n,) which pin, the number of
    the `picture` (n,) and of its `slide` (n,), the turntable's angle `turn` (n,) [rad].
    """

    u: Array
    v: Array
    sigma: Array
    half_width: Array
    near: NDArray[np.bool_]
    picture: Whole
    slide: Whole
    turn: Array

    def only(self, kept: NDArray[np.bool_]) -> "Sightings":
        return Sightings(*(getattr(self, name)[kept] for name in self.__dataclass_fields__))


class Image(NamedTuple):
    """Rays (n, 3) of the camera frame, their derivatives by u (n, 3) and by k (n, 3)."""

    ray: Array
    by_u: Array
    by_k: Array


@dataclass(frozen=True, eq=False)
class PinModel:
    """The two-pin fixture for a lens `law` and an image of `width` x `height` px. Readings `slides` (m,) [m] of the
    slide and those of the turntable, one for each of `pictures` (k,), are parameters too, known as well as read.
    `forwards`: 1 where a greater reading moves the camera back, -1 where it moves it forwards.
    """

    law: str
    width: int
    height: int
    slides: Array
    pictures: Whole
    forwards: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        pins = (f"{pin}.{name}" for pin in ("near", "far") for name in PIN)
        slides = (f"{SLIDE}{number}" for number in range(self.slides.size))
        return (PUPIL, K, *CAMERA, OFFSET, *pins, *slides, *(f"{TURN}{number}" for number in self.pictures))

    def predicted(self, values: Array, seen: Sightings) -> tuple[Array, Array]:
        """Columns u (n,) [px] of the pins' axes in the rows of `seen`, and their derivatives (n, p) by `names`."""
        camera, sight = self._camera(values[1]), self._sight(values, seen)
        rotation, _ = camera_rotation(*values[2:5])
        normal = np.einsum("ni,nij->nj", sight.normal, sight.turned) @ rotation
        u = np.array(seen.u)
        for _ in range(NEWTON_STEPS):
            image = self._image(camera, u, seen)
            u = u - _dot(normal, image.ray) / _dot(normal, image.by_u)
        image = self._image(camera, u, seen)
        by_parameters = self._columns(values, seen, sight, image)
        return u - self._lopsided(camera, u, seen), -by_parameters / _dot(normal, image.by_u)[:, None]

    def _camera(self, k: float) -> Camera:
        lens = Lens(self.law, float(k), self.height / 2)
        return Camera(self.width, self.height, lens, middle_of(self.width, self.height))

    @staticmethod
    def _image(camera: Camera, u: Array, seen: Sightings) -> Image:
        rays = camera.unproject_with_sensitivities(u, seen.v)
        k = camera.parameter_names.index(K)
        return Image(rays.direction, rays.direction_by_pixel[:, :, 0], rays.direction_by_parameters[:, :, k])

    @staticmethod
    def _lopsided(camera: Camera, u: Array, seen: Sightings) -> Array:
        """How far [px] the axis of a round pin, which halves the angle between its edges, appears from their middle."""
        left, middle, right = (
            np.arctan2(*camera.unproject(u + side * seen.half_width, seen.v).direction.T[[0, 2]]) for side in (-1, 0, 1)
        )
        return ((left + right) / 2 - middle) * 2 * seen.half_width / np.where(right > left, right - left, np.inf)

    def _sight(self, values: Array, seen: Sightings) -> "_Sight":
        """Pin and camera of each mark in the frame of the fixture."""
        picture = FIRST_SLIDE + self.slides.size + np.searchsorted(self.pictures, seen.picture)
        turned, turning = turn_about_pivot(seen.turn + values[picture])
        ahead = self.forwards * (values[0] - values[FIRST_SLIDE:][seen.slide])
        pupil, carried = (t[:, :, 0] * values[5] + t[:, :, 2] * ahead[:, None] for t in (turned, turning))
        x, z, lean_x, lean_z = np.where(seen.near, values[6:10, None], values[10:14, None])
        axis = np.stack([lean_x, np.ones_like(x), lean_z], axis=1)
        arm = np.stack([x, np.zeros_like(x), z], axis=1) - pupil
        return _Sight(picture, turned, turning, carried, axis, arm, np.cross(axis, arm))

    def _columns(self, values: Array, seen: Sightings, sight: "_Sight", image: Image) -> Array:
        """Derivatives (n, p) of the volume of axis, arm and ray by `names`."""
        camera, by_angles = camera_rotation(*values[2:5])
        ray = _times(sight.turned, image.ray @ camera.T)
        by_arm, by_axis = np.cross(ray, sight.axis), np.cross(sight.arm, ray)
        back = np.einsum("ni,nij->nj", sight.normal, sight.turned)
        columns, rows = np.zeros((len(ray), values.size)), np.arange(len(ray))
        columns[:, 0] = -self.forwards * _dot(by_arm, sight.turned[:, :, 2])
        columns[:, 1] = _dot(back @ camera, image.by_k)
        for number, by_angle in enumerate(by_angles):
            columns[:, 2 + number] = _dot(back @ by_angle, image.ray)
        columns[:, 5] = -_dot(by_arm, sight.turned[:, :, 0])
        by_pin = np.stack([by_arm[:, 0], by_arm[:, 2], by_axis[:, 0], by_axis[:, 2]], axis=1)
        columns[:, 6:10], columns[:, 10:14] = by_pin * seen.near[:, None], by_pin * ~seen.near[:, None]
        columns[rows, FIRST_SLIDE + seen.slide] = -columns[:, 0]
        turned = _dot(sight.normal, _times(sight.turning, image.ray @ camera.T))
        columns[rows, sight.picture] = turned - _dot(by_arm, sight.carried)
        return columns


class _Sight(NamedTuple):
    """Of n marks: column of their picture's turn (n,), rotation (n, 3, 3) and its slope by the turn, motion (n, 3) of
    the pupil by the turn, axis of the pin (n, 3), arm (n, 3) from pupil to pin, normal (n, 3) of the plane of both.
    """

    picture: Whole
    turned: Array
    turning: Array
    carried: Array
    axis: Array
    arm: Array
    normal: Array


def _dot(first: Array, second: Array) -> Array:
    return np.einsum("ni,ni->n", first, second)


def _times(matrices: Array, vectors: Array) -> Array:
    return np.einsum("nij,nj->ni", matrices, vectors)


def turn_about_pivot(turn: Array) -> tuple[Array, Array]:
    """Rotations (n, 3, 3) by `turn` (n,) [rad] about y, from z towards x: to the right; and their derivatives."""
    upright, cross = np.diag([0.0, 1.0, 0.0]), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    c, s, across = np.cos(turn)[:, None, None], np.sin(turn)[:, None, None], np.diag([1.0, 0.0, 1.0])
    return upright + c * across + s * cross, c * cross - s * across


def camera_rotation(yaw: float, pitch: float, roll: float) -> tuple[Array, Array]:
    """The camera in the slide's frame: yaw (to the right) after pitch (up) after roll (clockwise) [rad], and its
    derivatives (3, 3, 3) by them.
    """
    turns = [_about(axis, angle) for axis, angle in ((1, yaw), (0, pitch), (2, roll))]
    (y, by_yaw), (x, by_pitch), (z, by_roll) = turns
    return y @ x @ z, np.stack([by_yaw @ x @ z, y @ by_pitch @ z, y @ x @ by_roll])


def _about(axis: int, angle: float) -> tuple[Array, Array]:
    cross = np.cross(np.eye(3)[axis], np.eye(3)).T
    along = np.outer(np.eye(3)[axis], np.eye(3)[axis])
    plane = np.eye(3) - along
    return along + np.cos(angle) * plane + np.sin(angle) * cross, np.cos(angle) * cross - np.sin(angle) * plane

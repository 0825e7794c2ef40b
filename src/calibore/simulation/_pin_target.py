"""A photograph of upright pins before a bright background, seen by a camera on a slide that stands on a turntable."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera
from calibore.simulation._sensor import Sensor
from calibore.simulation._soft_edges import NEAR, TargetLight, photographed, softened

Array = NDArray[Any]

LIGHT = TargetLight(exposure=0.65, falloff=0.1, gradient=0.1)
AMBIENT = 0.7  # of the light on a pin comes from all sides, the rest from the camera


@dataclass(frozen=True)
class Pin:
    """An upright cylinder with its axis at `x`, `z` [m] of the fixture's frame (y down), `radius` [m], from `top` to
    `bottom` [m] in y; `albedo`: its brightness relative to the background.
    """

    x: float
    z: float
    radius: float
    top: float
    bottom: float
    albedo: float = 0.3

    def __post_init__(self) -> None:
        if not (self.radius > 0 and self.top < self.bottom and self.albedo >= 0):
            raise InputError(
                f"A pin needs a positive radius and its top above its bottom (y is down), "
                f"got radius {self.radius:g} m, top {self.top:g} m, bottom {self.bottom:g} m."
            )


def turntable_pose(forward: float, turn: float) -> Pose:
    """`fixture_from_camera`: the pupil stands `forward` [m] of the turntable's axis, which is the origin, along the
    camera's axis, and the camera is turned by `turn` [rad] to the right.
    """
    return Pose.from_roll_pitch_yaw(yaw=turn, translation=(forward * np.sin(turn), 0.0, forward * np.cos(turn)))


def photograph_pins(
    camera: Camera,
    fixture_from_camera: Pose,
    *,
    pins: Sequence[Pin],
    sensor: Sensor,
    rng: np.random.Generator,
    light: TargetLight = LIGHT,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w, 3) of `pins`; nearer ones hide farther ones. Their ends are cut flat where their axis ends."""
    eye = fixture_from_camera.translation
    scene = _Pins(tuple(sorted(pins, key=lambda pin: -np.hypot(pin.x - eye[0], pin.z - eye[2]))))
    picture = photographed(
        camera, scene, scene_from_camera=fixture_from_camera, light=light, psf_sigma=sensor.psf_sigma
    )
    return sensor.read_out(picture, rng)


@dataclass(frozen=True)
class _Pins:
    """Pins, the farthest first."""

    pins: tuple[Pin, ...]

    def lengths(self, origin: Array, direction: Array) -> Array:
        """How far rays pass to the right of each pin's axis, and at which y: (2 pins, n); NaN behind the camera."""
        level = np.hypot(direction[:, 0], direction[:, 2])
        rows = []
        for pin in self.pins:
            x, z = pin.x - origin[:, 0], pin.z - origin[:, 2]
            ahead = (x * direction[:, 0] + z * direction[:, 2]) / level
            passing = (z * direction[:, 0] - x * direction[:, 2]) / level
            rows += [np.where(ahead > 0, passing, np.nan), origin[:, 1] + ahead * direction[:, 1] / level]
        return np.array(rows)

    def appearance(self, lengths: Array, slopes: Array) -> tuple[Array, Array]:
        """Reflectance with softened edges, 1 for the background, and which rays pass an edge nearby."""
        reflectance = np.ones(lengths.shape[1])
        near = np.zeros(lengths.shape[1], dtype=bool)
        for number, pin in enumerate(self.pins):
            (passing, y), by_pixel = lengths[2 * number : 2 * number + 2], slopes[2 * number : 2 * number + 2]
            across, down = np.hypot(by_pixel[..., 0], by_pixel[..., 1])
            side = pin.radius - np.abs(passing)
            covered = softened(side, across) * (softened(y - pin.top, down) - softened(y - pin.bottom, down))
            facing = np.sqrt(np.clip(1 - (passing / pin.radius) ** 2, 0, 1))
            shade = pin.albedo * (AMBIENT + (1 - AMBIENT) * facing)
            reflectance += np.nan_to_num(covered) * (np.nan_to_num(shade) - reflectance)
            beside = (y > pin.top - NEAR * down) & (y < pin.bottom + NEAR * down)
            near |= (np.abs(side) < NEAR * across) & beside
            near |= (np.minimum(np.abs(y - pin.top), np.abs(y - pin.bottom)) < NEAR * down) & (side > -NEAR * across)
        return reflectance, near

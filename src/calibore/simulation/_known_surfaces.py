"""Surfaces whose place is known, to calibrate on: a flat target before a side-facing head; a ring gauge is a pipe."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import Rig
from calibore.simulation._light import LineLight, LitLine, inside_image, lit_line
from calibore.simulation._parts import WallPart, turned
from calibore.simulation._picture import photograph_all
from calibore.simulation._sensor import Sensor
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]
WIDEST = np.radians(60.0)
WIDE = 2.0  # of its distance: how far to either side a flat is looked at
BORDER = 3.0  # px; a line nearer to the picture's border counts as outside
OUTWARDS = np.pi
"""Clock, in the frame of a side-facing head, of its y axis."""


@dataclass(frozen=True)
class FlatFace(WallPart):
    """The wall is flat about `clock` [rad], at its nominal radius there, and rises outwards by `slope` along the axis:
    r = (R0 + slope z) / cos(clock - `clock`), within 60 deg.
    """

    clock: float = OUTWARDS
    slope: float = 0.0
    longest: float = 0.5

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        away = np.clip(turned(clock, self.clock), -WIDEST, WIDEST)
        return radius - nominal_radius + (nominal_radius + self.slope * np.clip(axial, *self._ends)) / np.cos(away)

    def reach(self, nominal_radius: float) -> float:
        return abs(self.slope) * self.longest

    def recess(self, nominal_radius: float) -> float:
        return (nominal_radius + abs(self.slope) * self.longest) / np.cos(WIDEST) - nominal_radius

    @property
    def _ends(self) -> tuple[float, float]:
        return -self.longest, self.longest


def lit_flat(rig: Rig, distance: float, *, slope: float = 0.0, line: LineLight, psf_sigma: float) -> LitLine:
    """The line that a side-facing head draws on a flat at `distance` [m] outwards, inclined by `slope` along travel."""
    if not 0 < distance < np.inf:
        raise InputError(f"A flat target stands at a positive distance, got {distance} m.")
    wall = PipeWall(distance, (FlatFace(slope=slope),))
    return lit_line(rig, wall, pipe_from_rig=Pose.identity(), line=line, psf_sigma=psf_sigma)


def sees_flat(rig: Rig, distance: float) -> bool:
    """Whether the camera of a side-facing head sees any of its line on a flat at `distance` [m]."""
    along = np.linspace(-WIDE, WIDE, 1001) * distance
    points = np.stack([np.zeros_like(along), np.full(along.shape, distance), along], axis=1)
    return bool(inside_image(*rig.project(points), rig, margin=-BORDER).any())


def photograph_flat(
    rig: Rig,
    distance: float,
    *,
    rng: np.random.Generator,
    slope: float = 0.0,
    line: LineLight | None = None,
    sensor: Sensor | None = None,
    room: float = 0.0,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w, 3) of that line, dark where it lies outside the picture; `room`: brightness of the target in
    room light, as a fraction of white.
    """
    line, sensor = line or LineLight(), sensor or Sensor()
    lines = {}
    if sees_flat(rig, distance):
        lines = {0: lit_flat(rig, distance, slope=slope, line=line, psf_sigma=sensor.psf_sigma)}
    picture = photograph_all(lines, rig, line=line, sensor=sensor, rng=rng)
    if room == 0:
        return picture
    white = np.iinfo(picture.dtype).max
    return np.minimum(picture + np.rint(room * white), white).astype(picture.dtype)

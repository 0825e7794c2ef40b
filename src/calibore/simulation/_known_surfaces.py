"""Surfaces whose place is known, to calibrate on: a flat target before a side-facing head; a ring gauge is a pipe."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import Rig
from calibore.simulation._files import write_png
from calibore.simulation._light import LineLight, LitLine, lit_line
from calibore.simulation._parts import WallPart, turned
from calibore.simulation._picture import photograph
from calibore.simulation._sensor import Sensor
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]
WIDEST = np.radians(60.0)
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
    """The picture (h, w, 3) of that line; `room`: brightness of the target in room light, as a fraction of white."""
    line, sensor = line or LineLight(), sensor or Sensor()
    lit = lit_flat(rig, distance, slope=slope, line=line, psf_sigma=sensor.psf_sigma)
    picture = photograph(lit, rig, line=line, sensor=sensor, rng=rng)
    if room == 0:
        return picture
    white = np.iinfo(picture.dtype).max
    return np.minimum(picture + np.rint(room * white), white).astype(picture.dtype)


def simulate_range_target(
    folder: Path,
    rig: Rig,
    indices: list[int],
    *,
    step: float,
    rng: np.random.Generator,
    u_range: float = 0.0,
    room_takes: tuple[int, ...] = (0,),
    takes: int = 2,
    design: str,
) -> list[float]:
    """Pictures "range {index:03d} {take}.png" of a flat at index x `step` [m], each stop off by chance with standard
    deviation `u_range` [m], and target.toml with the lines `design`; returns the true ranges.
    """
    true = []
    for index in indices:
        true.append(index * step + u_range * float(rng.standard_normal()))
        for take in range(takes):
            room = 0.4 if take in room_takes else 0.0
            write_png(folder / f"range {index:03d} {take}.png", photograph_flat(rig, true[-1], rng=rng, room=room))
    text = (
        'format = "calibore-target/1"\nkind = "range"\nimages = "range {index:03d} {take}.png"\n'
        f'range_step = "{1e3 * step:.9g} mm"\n{design}\n'
    )
    (folder / "target.toml").write_text(text, encoding="utf-8")
    return true

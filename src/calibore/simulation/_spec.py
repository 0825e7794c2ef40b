"""A simulation described by a file: which pipe, which rig, which path, which light (`calibore simulate SPEC`)."""

from itertools import product
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, Strict

from calibore.documents import Angle, Document, Length, read_document
from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import Rig, SideFacing, read_rig
from calibore.simulation._chance import draw_rig
from calibore.simulation._light import LineLight
from calibore.simulation._sensor import Sensor
from calibore.simulation._spec_effects import FinishTable, ImagesTable, LampTable, OverlayTable, WaterTable, WindowTable
from calibore.simulation._spec_parts import MOST, Count, Number, PartTable, Several
from calibore.simulation._survey import Station, Survey
from calibore.simulation._wall import PipeWall
from calibore.simulation._wander import Wander

Fraction = Annotated[float, Strict(), Field(ge=0, le=1)]


def _positive(value: float) -> float:
    if value <= 0:
        raise ValueError(f"it is {value:g} but must be greater than 0")
    return value


class PipeTable(Document):
    nominal_radius: Annotated[Length, AfterValidator(_positive)]
    parts: tuple[PartTable, ...] = ()
    finish: FinishTable | None = None
    water: WaterTable | None = None

    def wall(self, folder: Path) -> PipeWall:
        """The wall; files relative to `folder`."""
        parts = tuple(table.part(folder) for table in self.parts)
        finish = water = None
        if self.finish is not None:
            parts, finish = parts + self.finish.deposits(), self.finish.finish()
        if self.water is not None:
            water = self.water.water()
        return PipeWall(self.nominal_radius, parts, finish, water)


class AxialTable(Document):
    origin: Length
    step: Length
    stations: Several


class _Angular(Document):
    origin: Angle = 0.0
    step: Angle
    stops: Several


class PoseTable(Document):
    roll: Angle = 0.0
    pitch: Angle = 0.0
    yaw: Angle = 0.0
    x: Length = 0.0
    y: Length = 0.0


class _Wander(Document):
    roll: Angle = 0.0
    tilt: Angle = 0.0
    shift: Length = 0.0
    axial: Length = 0.0


class _Motion(Document):
    axial: AxialTable
    angular: _Angular | None = None
    takes: Several = 1
    pose: PoseTable = PoseTable()
    wander: _Wander = _Wander()


class _Shadow(Document):
    clock: Angle
    width: Angle


class LineTable(Document):
    sigma: Length = LineLight.sigma
    brightness: Annotated[float, Strict(), Field(ge=0)] = LineLight.brightness
    colour: tuple[Number, Number, Number] = LineLight.colour
    shadows: tuple[_Shadow, ...] = ()
    leaves: Annotated[int, Strict()] = LineLight.leaves


class SensorTable(Document):
    psf_sigma: Number = Sensor.psf_sigma
    speckle_contrast: Fraction = Sensor.speckle_contrast
    speckle_grain: Number = Sensor.speckle_grain
    take_decorrelation: Fraction = Sensor.take_decorrelation
    full_well: Number = Sensor.full_well
    read_noise: Number = Sensor.read_noise
    background: Number = Sensor.background
    bits: Literal[8, 16] = 8


class RigsNamed(Document):
    format: Literal["calibore-simulation/1"]
    name: Annotated[str, Field(min_length=1)]
    rig: str
    true_rig: str | None = None
    drawn: bool = False
    seed: Count = 0


class _Spec(RigsNamed):
    pipe: PipeTable
    motion: _Motion
    line: LineTable = LineTable()
    sensor: SensorTable = SensorTable()
    window: WindowTable = WindowTable()
    lamps: tuple[LampTable, ...] = ()
    overlays: tuple[OverlayTable, ...] = ()
    images: ImagesTable = ImagesTable()


def read_survey(path: Path | str, *, seed: int | None = None) -> tuple[Survey, int]:
    """The survey that `path` specifies, and its seed, or `seed` instead; raises InputError naming file and key."""
    path = Path(path)
    spec = read_document(path, _Spec)
    seed = spec.seed if seed is None else seed
    stated, true = rigs_of(spec, path, seed)
    turning = isinstance(true.mount, SideFacing)
    if turning != (spec.motion.angular is not None):
        raise InputError(
            f"{path}: a side-facing head needs motion.angular, and no other rig has it; {spec.rig} describes a "
            f"{true.configuration} rig."
        )
    motion, pose = spec.motion, spec.motion.pose
    rotation = {"roll": pose.roll, "pitch": pose.pitch, "yaw": pose.yaw}
    angular = motion.angular
    try:
        survey = Survey(
            name=spec.name,
            rig=true,
            wall=spec.pipe.wall(path.parent),
            stations=_stations(motion),
            origin=motion.axial.origin,
            step=motion.axial.step,
            pose=Pose.from_roll_pitch_yaw(**rotation, translation=(pose.x, pose.y, 0.0)),
            line=light_of(spec.line),
            sensor=Sensor(**spec.sensor.model_dump()),
            stated=stated,
            angular=None if angular is None else (angular.origin, angular.step),
            wander=Wander(**motion.wander.model_dump(), seed=seed),
            window=spec.window.window(),
            lamps=tuple(table.lamp() for table in spec.lamps),
            overlays=tuple(table.overlay() for table in spec.overlays),
            images=spec.images.storage(),
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return survey, seed


def rigs_of(spec: RigsNamed, path: Path, seed: int) -> tuple[Rig, Rig]:
    """The rig as its file describes it, and as it truly is: another file, a draw from what the first states, or it."""
    stated = read_rig(path.parent / spec.rig)
    if spec.true_rig is not None and spec.drawn:
        raise InputError(f"{path}: give true_rig, or drawn = true to draw it from the uncertainty of rig, not both.")
    if spec.true_rig is not None:
        return stated, read_rig(path.parent / spec.true_rig)
    if spec.drawn and stated.covariance is None:
        raise InputError(f"{path}: drawn = true needs a rig file that states its uncertainty; {spec.rig} does not.")
    return stated, draw_rig(stated, np.random.default_rng([seed, 2])) if spec.drawn else stated


def _stations(motion: _Motion) -> tuple[Station, ...]:
    stops = [None] if motion.angular is None else range(motion.angular.stops)
    total = motion.axial.stations * len(stops)
    if total > 10 * MOST:
        raise InputError(f"motion has {total} stops in all, at most {10 * MOST} can be simulated; give fewer stations.")
    return tuple(
        Station(number, motion.takes, angular=stop) for number, stop in product(range(motion.axial.stations), stops)
    )


def light_of(line: LineTable) -> LineLight:
    shadows = tuple((one.clock, one.width) for one in line.shadows)
    return LineLight(line.sigma, line.brightness, line.colour, shadows, line.leaves)

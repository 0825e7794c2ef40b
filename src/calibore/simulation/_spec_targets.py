"""Tables of a specification that describe a calibration target."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, Strict

from calibore.documents import Angle, Document, Length, read_document
from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.rigs import Rig, SideFacing, read_camera
from calibore.simulation._pin_target import Pin
from calibore.simulation._sensor import Sensor
from calibore.simulation._spec import LineTable, RigsNamed, SensorTable, light_of, rigs_of
from calibore.simulation._spec_parts import MOST, Count, Number, Several
from calibore.simulation._spec_touch import NotNegative, Positive, ProbeTable
from calibore.simulation._targets import (
    BoardTarget,
    Gauge,
    GaugeTarget,
    PinTarget,
    ProbeTarget,
    RangeTarget,
    RingTarget,
    Target,
    held_boards,
)
from calibore.targets import Board

Place = tuple[Length, Length]


class _Target(Document):
    stated: dict[str, Any] = Field(default_factory=dict)


class _Rings(_Target):
    kind: Literal["concentric-rings"]
    ring_spacing: Positive
    rings: Several
    spokes: Several = RingTarget.spokes
    ink_width: Positive | None = None
    centre: Place = (0.0, 0.0)
    roll: Angle = 0.0
    u_ring: NotNegative = 0.0
    takes: Several = 1


class _Range(_Target):
    kind: Literal["range"]
    indices: Annotated[tuple[Count, ...], Field(min_length=1)]
    step: Positive
    origin: Length = 0.0
    u_range: NotNegative = 0.0
    slope: Number = 0.0
    takes: Several = RangeTarget.takes
    room_takes: tuple[Count, ...] = RangeTarget.room_takes
    room: Number = RangeTarget.room


class _Gauge(Document):
    diameter: Positive
    centre: Place = (0.0, 0.0)


class _Gauges(_Target):
    kind: Literal["ring-gauge"]
    gauges: Annotated[tuple[_Gauge, ...], Field(min_length=1)]
    u: Positive = GaugeTarget.u
    u_tilt: Annotated[Angle, Field(gt=0)] = GaugeTarget.u_tilt
    takes: Several = 1


class _Pin(Document):
    x: Length
    z: Length
    radius: Positive
    top: Length
    bottom: Length
    albedo: Number = Pin.albedo


class _Pins(_Target):
    kind: Literal["two-pin"]
    camera: str
    pupil: Length
    slides: tuple[Length, ...]
    turns: tuple[Angle, ...]
    near: _Pin
    far: _Pin
    u_slide: NotNegative = PinTarget.u_slide
    u_turn: Annotated[Angle, Field(ge=0)] = PinTarget.u_turn


class _Board(_Target):
    kind: Literal["chessboard", "charuco", "circle-grid", "asymmetric-circle-grid"]
    camera: str
    corners: tuple[Count, Count]
    square: Positive
    stated_square: Positive | None = None
    marker: Positive | None = None
    dictionary: str = Board.dictionary
    dot: Positive | None = None
    boards: Several
    tilt: Annotated[Angle, Field(ge=0)] = 0.7


class _Probe(_Target):
    kind: Literal["probe"]
    probe: ProbeTable
    contacts: Annotated[tuple[Place, ...], Field(min_length=1)]
    lengths: Annotated[int, Strict(), Field(ge=2, le=MOST)] = ProbeTarget.lengths
    bend: Length = 0.0
    wrong: tuple[Length, ...] = ()
    u_caliper: NotNegative = ProbeTarget.u_caliper
    u_contact: NotNegative = ProbeTarget.u_contact


class _Kind(Document):
    model_config = ConfigDict(extra="ignore")

    kind: Literal[
        "concentric-rings", "range", "ring-gauge", "two-pin", "probe",
        "chessboard", "charuco", "circle-grid", "asymmetric-circle-grid",
    ]  # fmt: skip


class _Heading(Document):
    model_config = ConfigDict(extra="ignore")

    target: _Kind


class _RingsSpec(RigsNamed):
    target: _Rings
    sensor: SensorTable | None = None


class _RangeSpec(RigsNamed):
    target: _Range
    line: LineTable | None = None
    sensor: SensorTable | None = None


class _GaugesSpec(RigsNamed):
    target: _Gauges
    line: LineTable | None = None
    sensor: SensorTable | None = None


class _Alone(Document):
    format: Literal["calibore-simulation/1"]
    name: Annotated[str, Field(min_length=1)]
    seed: Count = 0


class _PinsSpec(_Alone):
    target: _Pins
    sensor: SensorTable | None = None


class _BoardSpec(_Alone):
    target: _Board
    sensor: SensorTable | None = None


class _ProbeSpec(_Alone):
    target: _Probe


def read_target(path: Path, *, seed: int | None) -> tuple[Target, int]:
    """The target that `path` specifies, and its seed, or `seed` instead."""
    kind = read_document(path, _Heading).target.kind
    model, make = _KINDS.get(kind, (_BoardSpec, _board))
    spec: Any = read_document(path, model)
    chosen: int = spec.seed if seed is None else seed
    return make(spec, path, chosen), chosen


def _said(spec: Any, *leave: str) -> dict[str, Any]:
    """What the table says in the words of the target's class."""
    said = {key: getattr(spec.target, key) for key in type(spec.target).model_fields if key not in ("kind", *leave)}
    line, sensor = (getattr(spec, key, None) for key in ("line", "sensor"))
    said |= {} if sensor is None else {"sensor": Sensor(**sensor.model_dump())}
    return said | ({} if line is None else {"line": light_of(line)})


def _rings(spec: _RingsSpec, path: Path, seed: int) -> Target:
    stated, true = rigs_of(spec, path, seed)
    plane, design = true.lasers[0].surface, stated.lasers[0].surface
    if not (isinstance(plane, Plane) and isinstance(design, Plane)):
        raise InputError(f"{path}: rings lie in a plane of light; {spec.rig} describes a {true.configuration} rig.")
    return RingTarget(true.camera, plane, nominal_baseline=design.baseline, **_said(spec))


def _range(spec: _RangeSpec, path: Path, seed: int) -> Target:
    stated, true = rigs_of(spec, path, seed)
    return RangeTarget(_turning(true, spec, path), design=stated, **_said(spec))


def _turning(rig: Rig, spec: _RangeSpec, path: Path) -> Rig:
    if not isinstance(rig.mount, SideFacing):
        raise InputError(
            f"{path}: kind range is for side-facing heads; {spec.rig} describes a {rig.configuration} rig."
        )
    return rig


def _gauges(spec: _GaugesSpec, path: Path, seed: int) -> Target:
    stated, true = rigs_of(spec, path, seed)
    gauges = tuple(Gauge(one.diameter, one.centre) for one in spec.target.gauges)
    return GaugeTarget(true, gauges, design=stated, **_said(spec, "gauges"))


def _pins(spec: _PinsSpec, path: Path, seed: int) -> Target:
    del seed
    near, far = (Pin(**one.model_dump()) for one in (spec.target.near, spec.target.far))
    camera = read_camera(path.parent / spec.target.camera).camera
    return PinTarget(camera, near=near, far=far, **_said(spec, "camera", "near", "far"))


def _board(spec: _BoardSpec, path: Path, seed: int) -> Target:
    said = spec.target
    marker = {} if said.marker is None else {"marker": said.marker / said.square}
    dot = {} if said.dot is None else {"dot": said.dot / said.square}
    board = Board(said.kind, said.corners, dictionary=said.dictionary, **marker, **dot)
    camera, rng = read_camera(path.parent / said.camera).camera, np.random.default_rng([seed, 3])
    poses = held_boards(camera, board, square=said.square, count=said.boards, rng=rng, tilt=said.tilt)
    drawn = ("camera", "corners", "marker", "dictionary", "dot", "boards", "tilt")
    return BoardTarget(camera, board, poses=poses, **_said(spec, *drawn))


def _probe(spec: _ProbeSpec, path: Path, seed: int) -> Target:
    del path, seed
    return ProbeTarget(spec.target.probe.probe(), **_said(spec, "probe"))


_KINDS: dict[str, tuple[type[Document], Callable[..., Target]]] = {
    "concentric-rings": (_RingsSpec, _rings),
    "range": (_RangeSpec, _range),
    "ring-gauge": (_GaugesSpec, _gauges),
    "two-pin": (_PinsSpec, _pins),
    "probe": (_ProbeSpec, _probe),
}

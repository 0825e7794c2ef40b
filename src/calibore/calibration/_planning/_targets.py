"""The targets that a next picture may show, with what is known of their making and of marks found on them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from calibore.calibration._rig._references import U_TILT
from calibore.documents import Angle, Document, Length, read_document
from calibore.errors import InputError

Array = NDArray[Any]
NOISE = 0.1
"""px: of one mark across its line; marks found to a tenth of a pixel are usual on sharp pictures."""
LINE_NOISE = 0.25
"""px: the same of a laser's line with its speckle, on a flat or in a gauge."""


@dataclass(frozen=True)
class PlannedRings:
    """`rings` at `spacing` [m] about one centre, `u_ring` [m] of each printed radius; `marks` per ring that are
    independent of each other, each known to `noise` [px] across the ring.
    """

    spacing: float
    rings: int
    u_ring: float = 5e-5
    marks: int = 60
    noise: float = NOISE

    def __post_init__(self) -> None:
        _check(spacing=self.spacing, rings=self.rings, marks=self.marks, noise=self.noise)

    @property
    def radii(self) -> Array:
        return self.spacing * np.arange(1, self.rings + 1)


@dataclass(frozen=True)
class PlannedBoard:
    """`columns` x `rows` marks at the distance `square` [m], each coordinate known to `noise` [px]. `staggered`: every
    other row moved on by one `square`, marks of a row two apart.
    """

    columns: int
    rows: int
    square: float
    noise: float = NOISE
    staggered: bool = False

    def __post_init__(self) -> None:
        _check(columns=self.columns, rows=self.rows, square=self.square, noise=self.noise)

    @property
    def marks(self) -> tuple[Array, Array]:
        """Places x, y (n,) [m] from its middle."""
        column, row = (a.ravel() for a in np.meshgrid(np.arange(self.columns), np.arange(self.rows)))
        x = 2 * column + row % 2 if self.staggered else column
        return (x - x.max() / 2) * self.square, (row - row.max() / 2) * self.square

    @property
    def diagonal(self) -> float:
        """[m]."""
        x, y = self.marks
        return float(2 * np.hypot(x.max(), y.max()))


@dataclass(frozen=True)
class PlannedGauges:
    """Ring gauges of `diameters` [m], `u` [m] of the radius of each; `u_tilt` of their setting up; `marks` round each
    that are independent of each other, known to `noise` [px] across the line.
    """

    diameters: tuple[float, ...]
    u: float = 1e-5
    u_tilt: float = float(U_TILT)
    marks: int = 72
    noise: float = LINE_NOISE

    def __post_init__(self) -> None:
        _check(diameters=min(self.diameters, default=0.0), marks=self.marks, noise=self.noise)


@dataclass(frozen=True)
class PlannedFlats:
    """A flat set up at any of `distances` [m] (ranges of a side-facing head; ahead of the camera for a cone), each
    reading known to `u` [m]; the rest as for gauges.
    """

    distances: tuple[float, ...]
    u: float = 1.3e-5
    u_tilt: float = float(U_TILT)
    marks: int = 60
    noise: float = LINE_NOISE

    def __post_init__(self) -> None:
        _check(distances=min(self.distances, default=0.0), marks=self.marks, noise=self.noise)


PlannedTarget = PlannedRings | PlannedBoard | PlannedGauges | PlannedFlats
Positive = Annotated[Length, Field(gt=0)]
Count = Annotated[int, Field(gt=1)]
BOARDS = ("chessboard", "charuco", "circle-grid", "asymmetric-circle-grid")
STEPS = 400
"""Stops of a slide at most; those that the camera does not see are dropped."""


class _Look(Document):
    """`u` of a diameter or a stand-off."""

    model_config = ConfigDict(extra="ignore")

    gauge: Positive | None = None
    flat: Positive | None = None
    u: Positive


class _AnyTarget(Document):
    """What a plan takes from target.toml; the rest concerns pictures that are there already."""

    model_config = ConfigDict(extra="ignore")

    format: Literal["calibore-target/1"]
    kind: str
    ring_spacing: Positive | None = None
    rings: Count | None = None
    u_ring: Positive | None = None
    corners: tuple[Count, Count] | None = None
    squares: tuple[Count, Count] | None = None
    square: Positive | None = None
    look: tuple[_Look, ...] = ()
    u_tilt: Annotated[Angle, Field(gt=0)] = float(U_TILT)
    range_step: Positive | None = None
    range_origin: Length = 0.0
    u_range: Positive | None = None


def read_planned_target(path: Path | str) -> PlannedTarget:
    """The target that `path`, target.toml or its folder, describes: rings, a board, gauges, or a flat on a slide.

    Raises InputError where a plan can make nothing of it.
    """
    path = Path(path)
    path = path / "target.toml" if path.is_dir() else path
    found = read_document(path, _AnyTarget)
    if found.kind == "concentric-rings":
        u_ring = found.u_ring or PlannedRings.u_ring
        return PlannedRings(_needed(path, found, "ring_spacing"), _needed(path, found, "rings"), u_ring=u_ring)
    if found.kind in BOARDS:
        columns, rows = found.squares or _needed(path, found, "corners")
        less, staggered = int(found.squares is not None), found.kind.startswith("asymmetric")
        return PlannedBoard(columns - less, rows - less, _needed(path, found, "square"), staggered=staggered)
    if found.kind == "range":
        step = _needed(path, found, "range_step")
        stops = (found.range_origin + step * np.arange(1, STEPS + 1)).tolist()
        u = found.u_range or PlannedFlats.u
        return PlannedFlats(tuple(stop for stop in stops if stop > 0), u=u, u_tilt=found.u_tilt)
    if found.kind == "ring-gauge" and found.look:
        return _gauges(found)
    raise InputError(
        f'{path}: next pictures of a target of kind "{found.kind}" cannot be planned; give one of kind '
        f"concentric-rings, {', '.join(BOARDS)}, ring-gauge or range."
    )


def _gauges(found: _AnyTarget) -> PlannedTarget:
    """The gauges at hand; where there are none, a flat at the stand-offs of before."""
    gauges = {look.gauge: look.u / 2 for look in found.look if look.gauge is not None}
    if gauges:
        return PlannedGauges(tuple(gauges), u=max(gauges.values()), u_tilt=found.u_tilt)
    flats = {look.flat: look.u for look in found.look if look.flat is not None}
    return PlannedFlats(tuple(flats), u=max(flats.values(), default=PlannedFlats.u), u_tilt=found.u_tilt)


def _needed(path: Path, found: _AnyTarget, key: str) -> Any:
    value = getattr(found, key)
    if value is None:
        raise InputError(f"{path}: key {key} is missing; add it.")
    return value


def _check(**values: float) -> None:
    for name, value in values.items():
        if not 0 < value < np.inf:
            raise InputError(f"{name} of a planned target must be positive, got {value}; lengths in metres.")

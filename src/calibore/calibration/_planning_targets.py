"""The targets that a next picture may show, with what is known of their making and of marks found on them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from calibore.calibration._references import U_TILT
from calibore.documents import Document, Length, read_document
from calibore.errors import InputError

Array = NDArray[np.float64]
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
    """`columns` x `rows` marks at the distance `square` [m], each coordinate known to `noise` [px]."""

    columns: int
    rows: int
    square: float
    noise: float = NOISE

    def __post_init__(self) -> None:
        _check(columns=self.columns, rows=self.rows, square=self.square, noise=self.noise)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m] between its outermost marks."""
        return (self.columns - 1) * self.square, (self.rows - 1) * self.square


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


class _AnyTarget(Document):
    """What a plan takes from target.toml; the rest concerns pictures that are there already."""

    model_config = ConfigDict(extra="ignore")

    format: Literal["calibore-target/1"]
    kind: str
    ring_spacing: Positive | None = None
    rings: Count | None = None
    u_ring: Positive | None = None
    corners: tuple[Count, Count] | None = None
    square: Positive | None = None
    range_step: Positive | None = None
    range_origin: Length = 0.0
    u_range: Positive | None = None


def read_planned_target(path: Path | str) -> PlannedTarget:
    """The target that `path`, target.toml or its folder, describes: rings, a board, or a flat on a slide. Raises
    InputError where a plan can make nothing of it.
    """
    path = Path(path)
    path = path / "target.toml" if path.is_dir() else path
    found = read_document(path, _AnyTarget)
    if found.kind == "concentric-rings":
        known = {} if found.u_ring is None else {"u_ring": found.u_ring}
        return PlannedRings(_needed(path, found, "ring_spacing"), _needed(path, found, "rings"), **known)
    if found.kind in BOARDS:
        columns, rows = _needed(path, found, "corners")
        return PlannedBoard(columns, rows, _needed(path, found, "square"))
    if found.kind == "range":
        step = _needed(path, found, "range_step")
        stops = (found.range_origin + step * np.arange(1, STEPS + 1)).tolist()
        known = {} if found.u_range is None else {"u": found.u_range}
        return PlannedFlats(tuple(stop for stop in stops if stop > 0), **known)
    raise InputError(
        f'{path}: next pictures of a target of kind "{found.kind}" cannot be planned; give one of kind '
        f"concentric-rings, {', '.join(BOARDS)} or range."
    )


def _needed(path: Path, found: _AnyTarget, key: str) -> Any:
    value = getattr(found, key)
    if value is None:
        raise InputError(f"{path}: key {key} is missing; add it.")
    return value


def _check(**values: float) -> None:
    for name, value in values.items():
        if not 0 < value < np.inf:
            raise InputError(f"{name} of a planned target must be positive, got {value}; lengths in metres.")

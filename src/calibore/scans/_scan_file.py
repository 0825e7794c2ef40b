"""scan.toml read, checked, and turned into a `ScanSpec` (contract, section 2)."""

import datetime
import hashlib
import json
import os
import string
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, Strict

from calibore.documents import Angle, Document, Length, filled, read_document
from calibore.errors import InputError
from calibore.scans._scan import AngularMotion, AxialMotion, ScanSpec, TactileTables, without_password

PATTERN_FIELDS = ("station", "angular", "take")


def read_scan(path: Path | str, *, stream: str | None = None) -> ScanSpec:
    """The scan described by `path`, a scan folder or its scan.toml; raises InputError naming file, key and remedy.

    `stream`: the camera whose pictures are measured while they come, in place of those that scan.toml names, if any.
    """
    toml = _toml_of(Path(path))
    document = read_document(toml, _Scan)
    if stream is not None:
        document = document.model_copy(update={"images": _Images(stream=stream), "tactile": None})
    _check_sources(document, toml)
    if document.images and document.images.pattern is not None:
        _check_pattern(document.images.pattern, document.motion, toml)
    return _spec(document, toml)


WIDEST = 1000.0
"""Lengths [m] beyond which their unit must be wrong: radii, tips, steps."""


def _positive(value: float) -> float:
    if value <= 0:
        raise ValueError(f"it is {value:g} m but must be greater than 0")
    if value > WIDEST:
        raise ValueError(f"it is {value:g} m, but no radius, tip or step is longer than {WIDEST:g} m; check its unit")
    return value


def _not_zero(value: float) -> float:
    if value == 0:
        raise ValueError("a step of 0 puts every station at the same place; give the distance between stations")
    return value


def _turning(value: float) -> float:
    if value == 0:
        raise ValueError("a step of 0 leaves the head at one clock; give the angle between angular stops")
    return value


def _this_format(value: str) -> str:
    if value != "calibore-scan/1":
        raise ValueError('this program reads scan files of format "calibore-scan/1"')
    return value


def _day(value: object) -> object:
    """2024-05-31, as TOML has it or as text; no time of day."""
    if isinstance(value, str):
        try:
            return datetime.date.fromisoformat(value)
        except ValueError as error:
            raise ValueError(f'"{value}" is no date; write e.g. 2024-05-31') from error
    if value is not None and type(value) is not datetime.date:
        raise ValueError(f"{value} is no date; write e.g. 2024-05-31")
    return value


PositiveLength = Annotated[Length, AfterValidator(_positive)]


class _Pipe(Document):
    nominal_radius: PositiveLength
    limit_deflection: Annotated[float, Strict(), Field(gt=0, le=100)] | None = None
    limit_ovality: Annotated[float, Strict(), Field(gt=0, le=100)] | None = None


class _Images(Document):
    pattern: str | None = None
    archive: str | None = None
    video: str | None = None
    stream: Annotated[str | None, Field(exclude_if=lambda value: value is None)] = None


class _Tactile(Document):
    signal: str
    bias: str
    tip_radius: PositiveLength
    probe: str | None = None
    drift: Annotated[Length, Field(ge=0)] | None = None


class _Axial(Document):
    origin: Length
    step: Annotated[Length, AfterValidator(_not_zero)]


class _Angular(Document):
    origin: Angle
    step: Annotated[Angle, AfterValidator(_turning)]


class _Motion(Document):
    axial: _Axial | None = None
    angular: _Angular | None = None
    table: str | None = None


class _Search(Document):
    inner: Annotated[float, Strict(), Field(gt=0, lt=1)] = 0.5
    outer: Annotated[float, Strict(), Field(gt=1)] = 1.5


class _Grid(Document):
    axial_step: PositiveLength | None = None


class _Scan(Document):
    format: Annotated[str, AfterValidator(_this_format)]
    name: Annotated[str, Field(min_length=1)]
    date: Annotated[datetime.date | None, BeforeValidator(_day)] = None
    rig: str | None = None
    pipe: _Pipe
    images: _Images | None = None
    tactile: _Tactile | None = None
    motion: _Motion
    search: _Search = _Search()
    grid: _Grid = _Grid()


def _toml_of(path: Path) -> Path:
    if not path.exists():
        raise InputError(f"{path} does not exist; give a scan folder or its scan.toml.")
    if not path.is_dir():
        return path
    if not (path / "scan.toml").is_file():
        raise InputError(f"{path} has no scan.toml; give a folder that holds one, or the path of the file itself.")
    return path / "scan.toml"


def _check_sources(document: _Scan, toml: Path) -> None:
    images, motion = document.images, document.motion
    named = [
        key
        for key, value in (
            ("images.pattern", images and images.pattern),
            ("images.video", images and images.video),
            ("images.stream", images and images.stream),
            ("[tactile]", document.tactile),
        )
        if value is not None
    ]
    if len(named) != 1:
        said = f"names {' and '.join(named)}" if named else "names no data"
        raise InputError(
            f"{toml} {said}; give exactly one of images.pattern, images.video, images.stream and [tactile]."
        )
    if images and images.archive is not None and images.pattern is None:
        raise InputError(
            f"{toml}: images.archive needs images.pattern beside it, the names that its pictures had as files."
        )
    if (motion.axial is None) == (motion.table is None):
        said = "both axial and table" if motion.axial else "neither axial nor table"
        raise InputError(f"{toml}: [motion] gives {said}; give exactly one of them.")
    if document.rig is None and document.tactile is None:
        raise InputError(f'{toml}: key rig is missing; add the rig file, e.g. rig = "rig.toml".')


def _fields(pattern: str) -> set[str]:
    return {field for _, field, _, _ in string.Formatter().parse(pattern) if field is not None}


def _check_pattern(pattern: str, motion: _Motion, toml: Path) -> None:
    where = f'{toml}: key images.pattern = "{pattern}" is wrong'
    try:
        fields = _fields(pattern)
        unknown = sorted(fields - set(PATTERN_FIELDS))
        if not unknown:
            filled(pattern, **dict.fromkeys(PATTERN_FIELDS, 0))
    except (ValueError, LookupError) as error:
        raise InputError(f"{where}: {error}. Write fields such as {{station:03d}}.") from error
    if unknown:
        raise InputError(f"{where}: field {{{unknown[0]}}} is not known; allowed: {', '.join(PATTERN_FIELDS)}.")
    if "station" not in fields:
        raise InputError(f"{where}: it has no field for the station; add one such as {{station:03d}}.")
    if motion.table is None and ("angular" in fields) != (motion.angular is not None):
        lack = "[motion] gives no angular" if "angular" in fields else "the pattern has no field {angular}"
        raise InputError(
            f"{where}: a side-facing scan needs both the field {{angular}} and motion.angular, but {lack}."
        )


def _spec(document: _Scan, toml: Path) -> ScanSpec:
    folder = toml.parent.resolve()

    def file(key: str, name: str) -> Path:
        if not os.path.isfile(folder / name):  # False too for what can be no name
            raise InputError(f'{toml}: key {key} = "{name}" names no existing file; paths are relative to {toml.name}.')
        return folder / name

    images, tactile, motion = document.images or _Images(), document.tactile, document.motion
    axial, angular, table = motion.axial, motion.angular, motion.table
    return ScanSpec(
        folder=folder,
        name=document.name,
        rig_path=None if document.rig is None else file("rig", document.rig),
        nominal_radius=document.pipe.nominal_radius,
        motion=AxialMotion(axial.origin, axial.step) if axial else file("motion.table", str(table)),
        identity=_identity(folder, document),
        pattern=images.pattern,
        archive=None if images.archive is None else _archive(folder, images.archive, toml),
        video=None if images.video is None else file("images.video", images.video),
        stream=images.stream,
        tactile=_tables(tactile, file) if tactile else None,
        angular=AngularMotion(angular.origin, angular.step) if angular else None,
        limit_deflection_percent=document.pipe.limit_deflection,
        limit_ovality_percent=document.pipe.limit_ovality,
        search_inner=document.search.inner,
        search_outer=document.search.outer,
        axial_step=document.grid.axial_step,
        date=document.date,
    )


def _archive(folder: Path, name: str, toml: Path) -> Path:
    if not os.path.isdir(folder / name):
        raise InputError(
            f'{toml}: key images.archive = "{name}" names no existing archive; paths are relative to {toml.name}.'
        )
    return folder / name


def _tables(tactile: _Tactile, file: Callable[[str, str], Path]) -> TactileTables:
    return TactileTables(
        file("tactile.signal", tactile.signal),
        file("tactile.bias", tactile.bias),
        tactile.tip_radius,
        None if tactile.probe is None else file("tactile.probe", tactile.probe),
        tactile.drift,
    )


def _identity(folder: Path, document: _Scan) -> str:
    kept = {"name": True, "images": {"pattern", "video", "stream"}, "tactile": {"signal", "bias"}}
    sources = document.model_dump(include=kept)  # pictures are the same ones in an archive
    if document.images and document.images.stream:
        sources["images"]["stream"] = without_password(document.images.stream)
    text = json.dumps([folder.name, sources], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]

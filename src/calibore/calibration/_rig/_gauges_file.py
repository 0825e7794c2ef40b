"""target.toml of kind "ring-gauge": ring gauges, or flats at known stand-offs, before a forward-looking rig."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from calibore.calibration._in_words import Unit
from calibore.calibration._rig._references import AHEAD, U_TILT, FlatTarget, Reference, RingGauge
from calibore.documents import Angle, Document, FileName, Length, read_document
from calibore.errors import InputError
from calibore.images import ImageFolder
from calibore.lasers import Beam, Cone
from calibore.rigs import CHANNELS, Rig, SideFacing, project_ring, read_camera, read_rig, triangulate
from calibore.uncertainty import Covariance

Positive = Annotated[Length, Field(gt=0)]


class LookTable(Document):
    """`images` of one placing, by {take}; the diameter of a `gauge` or the stand-off of a `flat` from the pupil, its
    standard uncertainty `u`, and `u_tilt` that of its slopes.
    """

    images: FileName
    gauge: Positive | None = None
    flat: Positive | None = None
    u: Positive
    u_tilt: Annotated[Angle, Field(gt=0)] | None = None


class GaugesFile(Document):
    format: Literal["calibore-target/1"]
    kind: Literal["ring-gauge"]
    rig: FileName
    lens_file: FileName | None = None
    channel: Literal["red", "green", "blue", "luma"] | None = None
    u_tilt: Annotated[Angle, Field(gt=0)] = float(U_TILT)
    look: Annotated[tuple[LookTable, ...], Field(min_length=1)]


@dataclass(frozen=True, eq=False)
class Placing:
    """One placing of a reference: what people call it, its pictures by take; `stop`: the thing it rests on."""

    name: str
    stop: str
    reference: Reference
    paths: dict[int, Path]


@dataclass(frozen=True, eq=False)
class GaugesTarget:
    """`rig` as designed; `camera`: what is known of its camera; `design`: what the rig file states of its lasers."""

    folder: Path
    rig: Rig
    camera: Covariance | None
    design: Covariance | None
    placings: tuple[Placing, ...]
    channels: tuple[str, ...]
    unit: Unit


def read_gauges_target(path: Path | str) -> GaugesTarget:
    """The target file `path`, or target.toml in that folder, and the files it names."""
    path = Path(path)
    path = path / "target.toml" if path.is_dir() else path
    said = read_document(path, GaugesFile)
    texts = tomllib.loads(path.read_text(encoding="utf-8"))["look"]
    rig = read_rig(path.parent / said.rig)
    stated = rig.covariance
    lasers = [] if stated is None else [name for name in stated.names if not name.startswith("camera.")]
    cameras = [] if stated is None else [name for name in stated.names if name.startswith("camera.")]
    camera = stated.restricted(cameras) if stated and cameras else None
    if said.lens_file is not None:
        known = read_camera(path.parent / said.lens_file)
        rig, camera = Rig(rig.configuration, known.camera, rig.lasers, stripe=rig.stripe), known.covariance
    _refuse_configuration(rig, path)
    placings = tuple(
        _placing(path, said, rig, number, text.get("gauge") or text.get("flat") or "")
        for number, text in enumerate(texts)
    )
    channels = tuple(said.channel or laser.channel or "red" for laser in rig.lasers)
    assert set(channels) <= set(CHANNELS)
    design = stated.restricted(lasers) if stated and lasers else None
    unit = Unit.of_length(texts[0].get("gauge") or texts[0].get("flat"))
    return GaugesTarget(path.parent, rig.knowing(None), camera, design, placings, channels, unit)


def _refuse_configuration(rig: Rig, path: Path) -> None:
    if isinstance(rig.mount, SideFacing):
        raise InputError(f"{path}: a {rig.configuration} rig is calibrated by a flat target at ranges; use kind range.")
    if isinstance(rig.lasers[0].surface, Beam):
        raise InputError(f"{path}: a {rig.configuration} rig draws no line, and there is no calibration for it.")


def _placing(path: Path, said: GaugesFile, rig: Rig, number: int, text: str) -> Placing:
    table = said.look[number]
    where = f"{path}: look[{number}]"
    if (table.gauge is None) == (table.flat is None):
        raise InputError(f"{where} needs gauge (a diameter) or flat (a stand-off from the pupil), one of them.")
    u_tilt = table.u_tilt or said.u_tilt
    paths = _pictures(path.parent, table.images, where)
    name = f"{'gauge' if table.gauge else 'flat'} {text}"
    if table.gauge is not None:
        ahead = _ahead(rig, table.gauge / 2, where)
        reference = RingGauge(table.gauge, at=ahead, u=table.u / 2, u_tilt=u_tilt)
        return Placing(f"look {number + 1} ({name})", name, reference, paths)
    if not isinstance(rig.lasers[0].surface, Cone):
        raise InputError(
            f"{where}: a flat across the axis is parallel to a plane of light and shows no line that tells anything; "
            "use ring gauges for this rig."
        )
    full = f"look {number + 1} ({name})"
    return Placing(full, full, FlatTarget(table.flat or 0.0, AHEAD, table.u, (u_tilt, u_tilt)), paths)


def _ahead(rig: Rig, radius: float, where: str) -> float:
    """Where along the axis [m] the light of the first laser falls on a round of `radius` [m]."""
    _, u, v = project_ring(rig, radius, 36)
    points = triangulate(rig, u, v, prior_radius=radius).points
    if not np.isfinite(points).any():
        raise InputError(
            f"{where}: the camera cannot see the light of this rig in a round of radius {1e3 * radius:.4g} mm; check "
            "its size, and baseline, lens and k of the rig."
        )
    return float(np.nanmean(points[:, 2]))


def _pictures(folder: Path, pattern: str, where: str) -> dict[int, Path]:
    """By take; a pattern without a field is the name of a file."""
    if "{take" not in pattern:
        file = folder / pattern
        if not file.is_file():
            raise InputError(
                f'{where}: there is no picture "{pattern}" in {folder}; write images as the file is named.'
            )
        return {0: file}
    try:
        found = ImageFolder(folder, pattern.replace("{take", "{station"))
    except InputError as error:
        raise InputError(f"{where}: {str(error).replace('{station', '{take')}") from error
    return {number: file for (number, _, _), file in found.paths.items()}

"""target.toml of kind "range": a flat target before a side-facing head."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from calibore.calibration._in_words import Unit
from calibore.calibration._rig._references import U_TILT
from calibore.documents import Angle, Document, FileName, Length, read_document
from calibore.errors import InputError
from calibore.images import ImageFolder
from calibore.lasers import Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing, read_camera, read_rig
from calibore.uncertainty import Covariance

Law = Literal["perspective", "stereographic", "equidistant", "sine-law", "equisolid-angle"]
Positive = Annotated[Length, Field(gt=0)]
DESIGN = ("design_baseline", "design_aim", "design_k", "lens")


class RangeFile(Document):
    """The range of a picture is `range_origin` + index x `range_step`, `u_range` its standard uncertainty, where the
    caliper's is known.
    """

    format: Literal["calibore-target/1"]
    kind: Literal["range"]
    images: FileName
    range_step: Positive
    range_origin: Length = 0.0
    u_range: Positive | None = None
    u_tilt: Annotated[Angle, Field(gt=0)] = float(U_TILT)
    room_light_takes: tuple[int, ...] | None = None
    channel: Literal["red", "green", "blue", "luma"] | None = None
    rig: FileName | None = None
    lens_file: FileName | None = None
    design_baseline: Positive | None = None
    design_aim: Annotated[Angle, Field(gt=0, lt=np.pi / 2)] | None = None
    design_k: Annotated[float, Field(gt=0)] | None = None
    lens: Law | None = None
    principal_point: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class RangeTarget:
    """`paths` of the pictures by index and take; `said`: what the file says; `unit` of its lengths."""

    folder: Path
    said: RangeFile
    paths: dict[int, dict[int, Path]]
    unit: Unit

    def range_of(self, index: int) -> float:
        return self.said.range_origin + index * self.said.range_step


def read_range_target(path: Path | str) -> RangeTarget:
    """The target file `path`, or target.toml in that folder, and the pictures it names."""
    path = Path(path)
    path = path / "target.toml" if path.is_dir() else path
    said = read_document(path, RangeFile)
    if "{index" not in said.images:
        raise InputError(f'{path}: images = "{said.images}" has no {{index}}; write e.g. "range {{index:03d}}.png".')
    try:
        pictures = ImageFolder(path.parent, said.images.replace("{index", "{station"))
    except InputError as error:
        raise InputError(f"{path}: {str(error).replace('{station', '{index')}") from error
    paths: dict[int, dict[int, Path]] = {}
    for (index, _, take), file in pictures.paths.items():
        paths.setdefault(index, {})[take] = file
    unit = Unit.of_length(tomllib.loads(path.read_text(encoding="utf-8"))["range_step"])
    return RangeTarget(path.parent, said, paths, unit)


def starting_rig(target: RangeTarget, size: tuple[int, int]) -> tuple[Rig, Covariance | None]:
    """The head as designed, and what is known of its camera and, where a rig file says so, of its sheet."""
    said, known = target.said, None
    if said.lens_file is not None:
        known = read_camera(target.folder / said.lens_file)
    if said.rig is not None:
        rig = read_rig(target.folder / said.rig)
        if not isinstance(rig.mount, SideFacing):
            raise InputError(f"{said.rig}: a {rig.configuration} rig is no side-facing head; use kind ring-gauge.")
        stated = rig.covariance
    else:
        rig, stated = _designed(target, size, needs_lens=known is None), None
    if known is not None:
        rig = Rig(rig.configuration, known.camera, rig.lasers, mount=rig.mount)
        return rig, _joined(known.covariance, stated)
    return rig, stated


def _designed(target: RangeTarget, size: tuple[int, int], *, needs_lens: bool) -> Rig:
    said = target.said
    missing = [key for key in (DESIGN if needs_lens else DESIGN[:2]) if getattr(said, key) is None]
    if missing:
        raise InputError(
            f"{target.folder / 'target.toml'}: the search needs a start; add {', '.join(missing)}, or rig, a rig file."
        )
    width, height = size
    centre = said.principal_point or (width / 2, height / 2)
    lens = Lens(said.lens or "equidistant", said.design_k or float(width), height / 2)
    mount = SideFacing(said.design_baseline or 0.0, said.design_aim or 0.0)
    camera = Camera(width, height, lens, centre)
    return Rig("side-facing", camera, (Laser(Sheet(), said.channel or "red"),), mount=mount)


def _joined(camera: Covariance | None, stated: Covariance | None) -> Covariance | None:
    """What the lens file says of the camera, and what the rig file says of the rest."""
    rest = [] if stated is None else [name for name in stated.names if not name.startswith("camera.")]
    if stated is None or not rest:
        return camera
    return stated.restricted(rest) if camera is None else camera.joined(stated.restricted(rest))

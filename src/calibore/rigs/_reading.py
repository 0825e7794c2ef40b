"""rig.toml -> Rig, or what of one it holds."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from calibore.documents import read_document
from calibore.errors import InputError
from calibore.optics import Camera, FlatPort, Lens
from calibore.rigs._configurations import CONFIGURATIONS, Configuration
from calibore.rigs._documents import CalibrationTable, CameraTable, Heading, camera_file, laser_keys, rig_file
from calibore.rigs._drift import widened
from calibore.rigs._mount import FORWARD, Mount, SideFacing
from calibore.rigs._rig import Laser, Rig
from calibore.rigs._stated import named_inputs, stated_inputs
from calibore.rigs._valid import ValidRegion
from calibore.uncertainty import Covariance


def read_rig(path: Path | str, *, drift: bool = True) -> Rig:
    """The rig described by `path` (formats.md, section 3); raises InputError naming file, key, value and what is
    allowed. A rig without stated uncertainty has `covariance` None: see `Rig.with_default_uncertainty`.

    `drift` False: as it was calibrated, without what its parameters may have moved by since.
    """
    path = Path(path)
    heading = read_document(path, Heading)
    if heading.configuration is None:
        raise InputError(f"{path}{_what_is_missing(heading)}")
    configuration = CONFIGURATIONS[heading.configuration]
    listed = isinstance(heading.laser, list) or configuration.lasers != (1, 1)
    document: Any = read_document(path, rig_file(configuration, listed=listed))
    tables = document.laser if listed else (document.laser,)
    try:
        lasers, mount = _lasers(tables, configuration), _mount(tables[0], configuration)
        known, stripe = known_by(document.calibration), document.uncertainty.stripe
        camera = camera_of(document.camera)
        rig = Rig(document.configuration, camera, lasers, mount=mount, stripe=stripe, valid=known.valid)
        covariance = _known_of(document, known, rig, laser_keys(configuration), drift=drift)
        return rig.knowing(covariance, known.degrees_of_freedom)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _what_is_missing(heading: Heading) -> str:
    """For a file without configuration: the rest of the sentence after its name."""
    if heading.laser is not None:
        return ": key configuration is missing; add it."
    if heading.camera is not None:
        return (
            " holds a camera without a laser: configuration and [laser] are missing. Join it with a laser by "
            "`calibore calibrate rig`, or add both."
        )
    return " holds no rig: configuration, [camera] and [laser] are missing. Give a rig file."


class Known(NamedTuple):
    """What [calibration] says of the parameters of a rig."""

    covariance: Covariance | None = None
    degrees_of_freedom: float | None = None
    valid: ValidRegion | None = None


def holds_rig(path: Path) -> bool:
    """Whether `path` names a configuration, as a whole rig file does."""
    return read_document(path, Heading).configuration is not None


def read_part(path: Path, *, drift: bool = True) -> tuple[Camera, Known]:
    """Camera of a whole or partial rig file, and what is known of its parameters, uncertainties stated included."""
    heading = read_document(path, Heading)
    if heading.configuration is not None:
        rig = read_rig(path, drift=drift)
        return rig.camera, Known(rig.covariance, rig.degrees_of_freedom, rig.valid)
    if heading.laser is not None:
        raise InputError(f"{path}{_what_is_missing(heading)}")
    if heading.camera is None:
        raise InputError(
            f"{path} holds no camera: [camera] is missing. Give a rig file, or what `calibore calibrate lens` wrote."
        )
    document: Any = read_document(path, camera_file())
    try:
        known = known_by(document.calibration)
        covariance = _known_of(document, known, None, {}, drift=drift)
        return camera_of(document.camera), known._replace(covariance=covariance)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def camera_of(table: CameraTable) -> Camera:
    lens = Lens(table.lens, table.k, table.height / 2, table.c1, table.c2, table.polynomial)
    port = table.port and FlatPort(**table.port.model_dump())
    return Camera(
        table.width, table.height, lens, table.principal_point, table.aspect, pupil_walk=table.pupil_walk, port=port
    )


def _lasers(tables: tuple[Any, ...], configuration: Configuration) -> tuple[Laser, ...]:
    names = set(configuration.surface.parameter_names)
    fixed = dict(configuration.fixed)
    lasers = []
    for table in tables:
        values = {key: getattr(table, key) for key in laser_keys(configuration) if key in names}
        if configuration.reversed and values["half_angle"] <= np.pi / 2:
            angle = np.degrees(values["half_angle"])
            raise InputError(
                "laser.half_angle of a reversed cone lies between 90 and 180 deg, from the forward axis to the light, "
                f"got {angle:.6g} deg; write {180 - angle:.6g} deg."
            )
        lasers.append(Laser(configuration.surface(**fixed, **values), table.channel, table.takes))
    return tuple(lasers)


def _mount(table: Any, configuration: Configuration) -> Mount:
    return SideFacing(table.baseline, table.aim) if configuration.side_facing else FORWARD


def _known_of(
    document: Any, known: Known, rig: Rig | None, keys: Mapping[str, Any], *, drift: bool
) -> Covariance | None:
    """What [uncertainty], [calibration] and, if asked for, [drift] say together."""
    together = _joined(stated_inputs(document.uncertainty, rig, keys), known.covariance)
    moving = named_inputs(document.drift, rig, keys, table_name="drift")
    return widened(together, moving) if drift else together


def _joined(stated: Covariance | None, calibrated: Covariance | None) -> Covariance | None:
    """The calibration's parameters, and uncorrelated with them those of [uncertainty]; None where neither names one."""
    if stated is None or calibrated is None:
        return calibrated or stated
    twice = set(stated.names) & set(calibrated.names)
    if twice:
        raise InputError(f"{', '.join(sorted(twice))} stand in [uncertainty] and in [calibration]; keep one of them.")
    return calibrated.joined(stated)


def known_by(calibration: CalibrationTable | None) -> Known:
    """What the table says. A calibration knows parameters too that are no rig's (the place of its target): left out."""
    if calibration is None:
        return Known()
    valid = calibration.valid and ValidRegion(calibration.valid.zenith, calibration.valid.radius)
    covariance = _covariance(calibration) if calibration.parameters or calibration.covariance else None
    if covariance and calibration.kind is not None:
        own = [name for name in covariance.names if name.startswith(("laser.", "camera."))]
        covariance = covariance.restricted(own) if own else None
    return Known(covariance, calibration.degrees_of_freedom, valid)


def _covariance(calibration: CalibrationTable) -> Covariance:
    if {len(row) for row in calibration.covariance} - {len(calibration.parameters)}:
        raise InputError(
            f"Every row of calibration.covariance needs {len(calibration.parameters)} numbers, one per parameter."
        )
    try:
        freedom = calibration.parameter_degrees_of_freedom
        return Covariance(calibration.parameters, np.array(calibration.covariance), degrees_of_freedom=freedom)
    except InputError as error:
        raise InputError(f"calibration.covariance: {error}") from error

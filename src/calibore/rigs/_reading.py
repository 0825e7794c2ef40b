"""rig.toml -> Rig."""

from pathlib import Path
from typing import Any

import numpy as np

from calibore.documents import read_document
from calibore.errors import InputError
from calibore.optics import Camera, FlatPort, Lens
from calibore.rigs._configurations import CONFIGURATIONS, Configuration
from calibore.rigs._documents import CalibrationTable, CameraTable, Heading, laser_keys, rig_file
from calibore.rigs._mount import FORWARD, Mount, SideFacing
from calibore.rigs._rig import Laser, Rig
from calibore.rigs._stated import stated_inputs
from calibore.uncertainty import Covariance


def read_rig(path: Path | str) -> Rig:
    """The rig described by `path` (formats.md, section 3); raises InputError naming file, key, value and what is
    allowed. A rig without stated uncertainty has `covariance` None: see `Rig.with_default_uncertainty`.
    """
    path = Path(path)
    heading = read_document(path, Heading)
    configuration = CONFIGURATIONS[heading.configuration]
    listed = isinstance(heading.laser, list) or configuration.lasers != (1, 1)
    document: Any = read_document(path, rig_file(configuration, listed=listed))
    tables = document.laser if listed else (document.laser,)
    try:
        lasers, mount = _lasers(tables, configuration), _mount(tables[0], configuration)
        rig = Rig(
            document.configuration, _camera(document.camera), lasers, mount=mount, stripe=document.uncertainty.stripe
        )
        stated = stated_inputs(document.uncertainty, rig, laser_keys(configuration))
        return rig.knowing(_covariance(stated, document.calibration), _degrees_of_freedom(document.calibration))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _camera(table: CameraTable) -> Camera:
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


def _degrees_of_freedom(calibration: CalibrationTable | None) -> float | None:
    return calibration.degrees_of_freedom if calibration else None


def _covariance(stated: Covariance | None, calibration: CalibrationTable | None) -> Covariance | None:
    """The calibration's parameters, and uncorrelated with them those of [uncertainty]; None where neither names one."""
    if calibration is None:
        return stated
    twice = set(stated.names if stated else ()) & set(calibration.parameters)
    if twice:
        raise InputError(f"{', '.join(sorted(twice))} stand in [uncertainty] and in [calibration]; keep one of them.")
    if {len(row) for row in calibration.covariance} - {len(calibration.parameters)}:
        raise InputError(
            f"Every row of calibration.covariance needs {len(calibration.parameters)} numbers, one per parameter."
        )
    try:
        calibrated = Covariance(calibration.parameters, np.array(calibration.covariance))
    except InputError as error:
        raise InputError(f"calibration.covariance: {error}") from error
    return calibrated.joined(stated) if stated else calibrated

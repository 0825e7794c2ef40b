"""rig.toml -> Rig."""

from pathlib import Path

import numpy as np

from calibore.documents import read_document
from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs._documents import (
    CalibrationTable,
    CameraTable,
    Heading,
    ListedLasersFile,
    PlaneTable,
    SingleLaserFile,
    UncertaintyTable,
)
from calibore.rigs._rig import Laser, Rig
from calibore.uncertainty import Covariance


def read_rig(path: Path | str) -> Rig:
    """The rig described by `path` (formats.md, section 3); raises InputError naming file, key, value and what is
    allowed. A rig without stated uncertainty has `covariance` None: see `Rig.with_default_uncertainty`.
    """
    path = Path(path)
    heading = read_document(path, Heading)
    document = read_document(path, ListedLasersFile if isinstance(heading.laser, list) else SingleLaserFile)
    tables = document.laser if isinstance(document, ListedLasersFile) else (document.laser,)
    try:
        return Rig(
            document.configuration,
            _camera(document.camera),
            tuple(_laser(table) for table in tables),
            covariance=_covariance(document.uncertainty, document.calibration),
            stripe=document.uncertainty.stripe,
            degrees_of_freedom=document.calibration.degrees_of_freedom if document.calibration else None,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _camera(table: CameraTable) -> Camera:
    lens = Lens(table.lens, table.k, table.height / 2, table.c1, table.c2, table.polynomial)
    return Camera(table.width, table.height, lens, table.principal_point, table.aspect)


def _laser(table: PlaneTable) -> Laser:
    return Laser(Plane(table.baseline, table.tilt_x, table.tilt_y), table.channel, table.takes)


def _covariance(uncertainty: UncertaintyTable, calibration: CalibrationTable | None) -> Covariance | None:
    """The calibration's parameters, and uncorrelated with them those of [uncertainty]; None where neither names one."""
    independent = _independent(uncertainty)
    if calibration is None:
        return Covariance.independent(independent) if independent else None
    twice = set(independent) & set(calibration.parameters)
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
    return calibrated.joined(Covariance.independent(independent)) if independent else calibrated


def _independent(table: UncertaintyTable) -> dict[str, float]:
    """Standard uncertainties by dotted path, as far as stated."""
    stated = table.model_dump(exclude={"stripe", "principal_point"}, exclude_none=True)
    laser = PlaneTable.model_fields.keys()
    paths = {f"{'laser' if name in laser else 'camera'}.{name}": u for name, u in stated.items()}
    if table.principal_point is not None:
        paths |= dict.fromkeys(("camera.principal_point_u", "camera.principal_point_v"), table.principal_point)
    return paths

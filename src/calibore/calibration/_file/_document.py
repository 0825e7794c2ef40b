"""What a calibration's FILE says -> Calibration without its evidence."""

from collections.abc import Iterable
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field

from calibore.calibration._calibration import Calibration, Comparison, Observations
from calibore.calibration._input_files import InputFile
from calibore.documents import Angle, Document, Length, read_document
from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.optics import Camera
from calibore.rigs import Laser, Rig, ValidRegion, read_camera, read_rig, value_of
from calibore.uncertainty import Covariance, Quantity

AnyNumber = Annotated[float, Field(allow_inf_nan=True)]
"""What was not computed is NaN."""
TABLES = ("format", "configuration", "camera", "laser", "uncertainty", "calibration", "drift")
"""Of a rig file; others are settings."""
CHANGED, ROUNDING = 1e-6, 1e-12
"""Of its u and of the value itself: a difference of rounding is no change by hand."""


class EstimateTable(Document):
    value: AnyNumber
    u: AnyNumber
    degrees_of_freedom: AnyNumber = inf


class ModelTable(Document):
    model: str
    parameters: int
    rmse: AnyNumber = nan
    aicc: AnyNumber = nan
    bic: AnyNumber = nan
    cross_validated: AnyNumber = nan
    estimates: dict[str, EstimateTable] = Field(default_factory=dict)
    remark: str = ""
    unit: str = "px"


class FileTable(Document):
    name: str
    sha256: str
    refused: str = ""
    set_aside: str = ""


class ValidTable(Document):
    zenith: tuple[Angle, Angle] | None = None
    radius: tuple[Length, Length] | None = None


class CalibrationTable(Document):
    kind: str
    created_by: str
    evidence: str
    parameters: tuple[str, ...]
    values: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    parameter_degrees_of_freedom: tuple[AnyNumber, ...] | None = None
    degrees_of_freedom: float = inf
    noise: AnyNumber
    group_sigma: AnyNumber
    findings: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    valid: ValidTable | None = None
    model: tuple[ModelTable, ...] = ()
    file: tuple[FileTable, ...] = ()
    settings: dict[str, dict[str, Any]] = Field(default_factory=dict)


class CalibrationFile(Document):
    """A rig file with a [calibration] that says where it comes from."""

    model_config = ConfigDict(extra="allow")

    format: str
    camera: Any = None
    laser: Any = None
    calibration: CalibrationTable


def read_table(path: Path) -> CalibrationFile:
    """The file's tables; raises InputError where no calibration wrote it."""
    heading = read_document(path, _Heading)
    if not isinstance(heading.calibration, dict) or "kind" not in heading.calibration:
        raise InputError(
            f"{path} says nothing of how it was calibrated: [calibration] or its kind is missing. Give a file that "
            "`calibore calibrate` wrote."
        )
    return read_document(path, CalibrationFile)


class _Heading(Document):
    model_config = ConfigDict(extra="ignore")

    calibration: Any = None


def calibration_of(path: Path, file: CalibrationFile, observations: Observations) -> Calibration:
    """Everything the file says, with the `observations` it rests on."""
    table = file.calibration
    count, got = len(table.parameters), len(table.values)
    if got != count:
        raise InputError(f"{path}: calibration.values: {count} parameters need as many values, got {got}.")
    if [len(row) for row in table.covariance] != [count] * count:
        raise InputError(
            f"{path}: calibration.covariance: {count} parameters need as many rows of as many numbers; restore the "
            "file, or calibrate again."
        )
    values = dict(zip(table.parameters, table.values, strict=True))
    rig, camera = _parts(path, file)
    covariance = Covariance(
        table.parameters,
        np.array(table.covariance),
        degrees_of_freedom=table.parameter_degrees_of_freedom,
    )
    _check_unchanged(path, rig or camera, zip(values, values.values(), covariance.u, strict=True))
    return Calibration(
        kind=table.kind,
        rig=rig,
        camera=camera,
        values=values,
        covariance=covariance,
        degrees_of_freedom=table.degrees_of_freedom,
        noise=table.noise,
        group_sigma=table.group_sigma,
        files=tuple(InputFile(**one.model_dump()) for one in table.file),
        observations=observations,
        valid=table.valid and ValidRegion(table.valid.zenith, table.valid.radius),
        models=tuple(_model(one) for one in table.model),
        settings=table.settings or {key: value for key, value in (file.model_extra or {}).items() if key not in TABLES},
        findings=table.findings,
        warnings=table.warnings,
    )


def _parts(path: Path, file: CalibrationFile) -> tuple[Rig | None, Camera | None]:
    if file.laser is not None:
        rig = read_rig(path, drift=False)
        return rig, rig.camera
    return None, read_camera(path, drift=False).camera if file.camera is not None else None


def _check_unchanged(path: Path, part: Rig | Camera | None, known: Iterable[tuple[str, float, float]]) -> None:
    """Raise InputError where a parameter is no longer what was calibrated: its covariance would mean nothing. `known`:
    names, values and standard uncertainties.
    """
    if part is None:
        return
    holder = Rig("perpendicular-plane", part, (Laser(Plane(1.0)),)) if isinstance(part, Camera) else part
    for name, value, u in known:
        if name in part.parameter_names and abs(value_of(holder, name) - value) > CHANGED * u + ROUNDING * abs(value):
            raise InputError(
                f"{path}: {name} is {value_of(holder, name):.10g} in the rig but was calibrated as {value:.10g}; put "
                "the calibrated value back, or calibrate again."
            )


def _model(table: ModelTable) -> Comparison:
    estimates = {name: Quantity(one.value, one.u, one.degrees_of_freedom) for name, one in table.estimates.items()}
    return Comparison(
        table.model,
        table.parameters,
        table.rmse,
        table.aicc,
        table.bic,
        table.cross_validated,
        estimates,
        table.remark,
        table.unit,
    )

"""A tactile probe: how far its tip reaches for the ratio of signal to bias voltage (Swanbom 2007, eq. 8-2)."""

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, Field

from calibore.documents import Document, Length, read_document
from calibore.errors import InputError
from calibore.rigs._documents import Number, Positive
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
PARAMETERS = ("probe.slope", "probe.intercept")


@dataclass(frozen=True, eq=False)
class Probe:
    """Radius = slope ratio + intercept [m], from the axis the probe turns about to the end of its tip.

    `covariance` of "probe.slope", "probe.intercept", common to all readings; `noise` [m]: standard deviation of the
    radius from one reading; `degrees_of_freedom` of the covariance.
    """

    slope: float
    intercept: float
    covariance: Covariance
    noise: float = 0.0
    degrees_of_freedom: float = inf

    def __post_init__(self) -> None:
        if self.slope == 0 or not np.isfinite([self.slope, self.intercept]).all():
            raise InputError(f"A probe's slope must not be 0, got {self.slope} m, with intercept {self.intercept} m.")
        if not 0 <= self.noise < inf:
            raise InputError(f"A probe's noise must not be negative, got {self.noise} m.")
        if tuple(self.covariance.names) != PARAMETERS:
            raise InputError(
                f"A probe's covariance is that of {' and '.join(PARAMETERS)}, got {', '.join(self.covariance.names)}."
            )

    def radius(self, ratio: ArrayLike) -> Array:
        """Radius [m] at each ratio of signal to bias voltage, its shape."""
        return self.slope * np.asarray(ratio, dtype=float) + self.intercept

    def sensitivities(self, ratio: ArrayLike) -> Array:
        """Derivatives (..., 2) of the radius by slope and intercept."""
        ratio = np.asarray(ratio, dtype=float)
        return np.stack([ratio, np.ones_like(ratio)], axis=-1)

    def u_common(self, ratio: ArrayLike) -> Array:
        """Standard uncertainty [m] that all radii share through slope and intercept, the shape of `ratio`."""
        by_both = self.sensitivities(ratio)
        return np.sqrt(np.einsum("...i,ij,...j->...", by_both, self.covariance.matrix, by_both))


class _ProbeTable(Document):
    slope: Length
    intercept: Length
    noise: Annotated[Length, Field(ge=0)] = 0.0


class _CalibrationTable(Document):
    model_config = ConfigDict(extra="ignore")

    parameters: tuple[str, ...]
    covariance: tuple[tuple[Number, ...], ...]
    degrees_of_freedom: Positive | None = None


class _ProbeFile(Document):
    model_config = ConfigDict(extra="ignore")

    format: Literal["calibore-rig/1"]
    configuration: Literal["tactile-probe"] = "tactile-probe"
    probe: _ProbeTable
    calibration: _CalibrationTable | None = None


def read_probe(path: Path | str) -> Probe:
    """The probe described by `path`, as `calibore calibrate probe` writes it; raises InputError naming file, key and
    what is allowed. A file without [calibration] states a probe without uncertainty.
    """
    path = Path(path)
    document = read_document(path, _ProbeFile)
    table, calibration = document.probe, document.calibration
    try:
        covariance = Covariance(PARAMETERS, np.zeros((2, 2)))
        if calibration is not None:
            covariance = Covariance(calibration.parameters, _square(calibration)).restricted(PARAMETERS)
        freedom = (calibration and calibration.degrees_of_freedom) or inf
        return Probe(table.slope, table.intercept, covariance, table.noise, freedom)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _square(calibration: _CalibrationTable) -> Array:
    count = len(calibration.parameters)
    if [len(row) for row in calibration.covariance] != [count] * count:
        raise InputError(f"calibration.covariance needs {count} rows of {count} numbers, one per parameter.")
    return np.array(calibration.covariance)

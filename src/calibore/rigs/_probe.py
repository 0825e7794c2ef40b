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
    radius from one reading; `degrees_of_freedom` of the covariance. `linearity` [m]: how far the potentiometer may be
    from straight, one standard deviation of the second Legendre polynomial over the `stroke` of ratios calibrated.
    """

    slope: float
    intercept: float
    covariance: Covariance
    noise: float = 0.0
    degrees_of_freedom: float = inf
    linearity: float = 0.0
    stroke: tuple[float, float] = (0.0, 1.0)

    def __post_init__(self) -> None:
        if self.slope == 0 or not np.isfinite([self.slope, self.intercept]).all():
            raise InputError(f"A probe's slope must not be 0, got {self.slope} m, with intercept {self.intercept} m.")
        if not (0 <= self.noise < inf and 0 <= self.linearity < inf):
            raise InputError(
                f"A probe's noise and linearity must not be negative, got {self.noise}, {self.linearity} m."
            )
        if not self.stroke[0] < self.stroke[1]:
            raise InputError(f"A probe's stroke goes from a smaller to a larger ratio, got {self.stroke}.")
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

    @property
    def anchor(self) -> float:
        """The ratio at which the radius is known best: that of the diameters which gave the intercept."""
        (variance, shared), _ = self.covariance.matrix
        return float(-shared / variance) if variance > 0 else sum(self.stroke) / 2

    def common_modes(self, ratio: ArrayLike) -> Array:
        """(..., 3) [m]: what all radii share, in three independent causes, one standard deviation of each: the radius
        at the anchor, the slope about it, and the bend of the line about it.
        """
        ratio, anchor = np.asarray(ratio, dtype=float), self.anchor
        at_anchor = self.sensitivities(anchor) @ self.covariance.matrix @ self.sensitivities(anchor)
        half, middle = (self.stroke[1] - self.stroke[0]) / 2, sum(self.stroke) / 2
        here, there = (((place - middle) / half) ** 2 for place in (ratio, anchor))
        modes = (np.sqrt(at_anchor), self.covariance.u[0] * (ratio - anchor), self.linearity * 1.5 * (here - there))
        return np.stack(np.broadcast_arrays(*modes), axis=-1)

    def u_common(self, ratio: ArrayLike) -> Array:
        """Standard uncertainty [m] that all radii share, the shape of `ratio`."""
        return np.linalg.norm(self.common_modes(ratio), axis=-1)


class _ProbeTable(Document):
    slope: Length
    intercept: Length
    noise: Annotated[Length, Field(ge=0)] = 0.0
    linearity: Annotated[Length, Field(ge=0)] = 0.0
    stroke: tuple[Number, Number] = (0.0, 1.0)


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
        return Probe(table.slope, table.intercept, covariance, table.noise, freedom, table.linearity, table.stroke)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _square(calibration: _CalibrationTable) -> Array:
    count = len(calibration.parameters)
    if [len(row) for row in calibration.covariance] != [count] * count:
        raise InputError(f"calibration.covariance needs {count} rows of {count} numbers, one per parameter.")
    return np.array(calibration.covariance)

"""What a calibration found, and its evidence."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._input_files import InputFile
from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import Rig, ValidRegion
from calibore.uncertainty import Covariance, Quantity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """One model that was tried: its number of `parameters`, `rmse` of the residuals, information criteria relative to
    the best, `cross_validated` rmse of data left out; `estimates` of the parameters that matter; `remark`: what cannot
    be told by it, or why it is not recommended. rmse in `unit`.
    """

    model: str
    parameters: int
    rmse: float
    aicc: float
    bic: float
    cross_validated: float
    estimates: Mapping[str, Quantity] = field(default_factory=dict)
    remark: str = ""
    unit: str = "px"


@dataclass(frozen=True, eq=False)
class Observations:
    """One row per residual: the `file` (n,) it came from (index of `Calibration.files`), its place `u`, `v` (n,) [px]
    (NaN where it has none), `residual` (n,) measured minus predicted, its standard deviation `sigma` (n,), `weight`
    (n,) 0 where it was left out, `group` (n,) of residuals that share an error, and `jacobian` (n, q) of the
    predictions by the parameters `names` (q,): those calibrated and those of poses. Residuals in `unit`.
    Of a fit: `Observations(file=..., u=..., v=..., **of_fit(fit))`, `of_fit` from `_evidence`.

    What ties residuals together, as `fitting.least_squares` takes it: `load` (n,) what a unit of its group's error does
    to each, None for 1; `chain` (n,) of neighbours in their order, -1 for none, None without chains; `prior` (k, q + 1)
    rows of unit variance: L (parameters - values) = the last column; `known_noise`: sigma is known, not estimated;
    `known_group_sigma`: so is that of the groups, None where it was estimated.
    `whitened` (m, q), where no such fit was made: (whitened' whitened)^-1 is the covariance of `names`.
    """

    file: NDArray[np.intp]
    u: Array
    v: Array
    residual: Array
    sigma: Array
    weight: Array
    group: NDArray[np.intp]
    jacobian: Array
    names: tuple[str, ...]
    unit: str = "px"
    load: Array | None = None
    chain: NDArray[np.intp] | None = None
    prior: Array | None = None
    known_noise: bool = False
    known_group_sigma: float | None = None
    whitened: Array | None = None

    @property
    def typical_load(self) -> float:
        """What a unit of its group's error typically does to a residual."""
        if self.load is None or not self.load.any():
            return 1.0
        return float(1 / np.median(1 / np.abs(self.load[self.load != 0])))

    def __post_init__(self) -> None:
        n, q = self.residual.size, len(self.names)
        rows = ("file", "u", "v", "residual", "sigma", "weight", "group", "load", "chain")
        shapes: dict[str, tuple[int, ...]] = dict.fromkeys(rows, (n,)) | {"jacobian": (n, q)}
        for name, columns in (("prior", q + 1), ("whitened", q)):
            values = getattr(self, name)
            shapes |= {} if values is None else {name: (len(values), columns)}
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values is not None and values.shape != shape:
                raise InputError(f"Observations need {name} of shape {shape}, got {values.shape}.")


@dataclass(frozen=True, eq=False)
class Calibration:
    """`kind` as in target.toml; `rig` or `camera` that was found, None where neither is (probe, pupil).

    `values` of the parameters, SI or px, by dotted path, in the order of `covariance`, which holds those calibrated;
    `degrees_of_freedom` of the scatter it rests on; `noise` of one residual and `group_sigma` of what groups share, in
    the observations' unit. `valid`: where points were. `settings`: further tables for the file, plain values.
    `findings`: sentences for people, the recommendation first; `warnings`: what they must not overlook.
    """

    kind: str
    rig: Rig | None
    camera: Camera | None
    values: Mapping[str, float]
    covariance: Covariance
    degrees_of_freedom: float
    noise: float
    group_sigma: float
    files: tuple[InputFile, ...]
    observations: Observations
    valid: ValidRegion | None = None
    models: tuple[Comparison, ...] = ()
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    findings: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

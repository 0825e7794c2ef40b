"""The tables of a rig file (formats.md, section 3), each key with what it may be."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, Strict

from calibore.documents import Document, Length

CONFIGURATIONS = ("perpendicular-plane", "single-cone", "dual-cone", "side-facing", "coaxial-cone", "rotating-spot")
SUPPORTED = ("perpendicular-plane",)

Number = Annotated[float, Strict()]
Positive = Annotated[Number, Field(gt=0)]
StandardUncertainty = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, Strict(), Field(gt=0)]


def _known(configuration: str) -> str:
    if configuration not in CONFIGURATIONS:
        raise ValueError(f"it is not known; allowed: {', '.join(CONFIGURATIONS)}")
    if configuration not in SUPPORTED:
        raise ValueError(f"it is known, but this version can only profile with: {', '.join(SUPPORTED)}")
    return configuration


class Heading(Document):
    """Read first: what the other tables may hold depends on it."""

    model_config = ConfigDict(extra="ignore")

    format: Literal["calibore-rig/1"]
    configuration: Annotated[str, AfterValidator(_known)]
    laser: Any = None


class CameraTable(Document):
    width: Whole
    height: Whole
    lens: Literal["perspective", "stereographic", "equidistant", "sine-law", "equisolid-angle", "polynomial"]
    k: Positive
    principal_point: tuple[Number, Number]
    c1: Number = 0.0
    c2: Number = 0.0
    aspect: Positive = 1.0
    polynomial: tuple[Number, ...] = ()


class PlaneTable(Document):
    baseline: Annotated[Length, Field(gt=0)]
    tilt_x: Number = 0.0
    tilt_y: Number = 0.0
    channel: Literal["red", "green", "blue", "luma"] | None = None
    takes: Annotated[tuple[Annotated[int, Strict()], ...], Field(min_length=1)] | None = None


class UncertaintyTable(Document):
    """Standard uncertainties (k = 1) of independent inputs; `principal_point` [px] counts for u and for v."""

    baseline: Annotated[Length, Field(ge=0)] | None = None
    tilt_x: StandardUncertainty | None = None
    tilt_y: StandardUncertainty | None = None
    k: StandardUncertainty | None = None
    c1: StandardUncertainty | None = None
    c2: StandardUncertainty | None = None
    aspect: StandardUncertainty | None = None
    principal_point: StandardUncertainty | None = None
    stripe: StandardUncertainty | None = None


class CalibrationTable(Document):
    parameters: tuple[str, ...]
    covariance: tuple[tuple[Number, ...], ...]
    degrees_of_freedom: Positive | None = None
    evidence: str | None = None


class _RigFile(Document):
    format: str
    configuration: str
    camera: CameraTable
    uncertainty: UncertaintyTable = UncertaintyTable()
    calibration: CalibrationTable | None = None


class SingleLaserFile(_RigFile):
    """With one [laser] table."""

    laser: PlaneTable


class ListedLasersFile(_RigFile):
    """With [[laser]] tables; a perpendicular plane has one."""

    laser: Annotated[tuple[PlaneTable, ...], Field(min_length=1, max_length=1)]

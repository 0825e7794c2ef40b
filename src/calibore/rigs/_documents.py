"""The tables of a rig file (formats.md, section 3), each key with what it may be."""

from dataclasses import MISSING, fields
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Strict, Tag, create_model

from calibore.documents import UNNAMED, Angle, Document, Length
from calibore.rigs._configurations import CONFIGURATIONS, Configuration

Number = Annotated[float, Strict()]
Positive = Annotated[Number, Field(gt=0)]
Whole = Annotated[int, Strict(), Field(gt=0)]
LARGEST = 1e9
"""Any standard uncertainty: beyond every unit, and its square is still a number."""
LENGTHS = frozenset({"baseline", "offset", "x", "y", "z"})
ANGLES = frozenset({"aim", "half_angle", "clock", "zenith"})


def quantity_of(name: str) -> Any:
    """The type of a laser's key: a length, an angle or a pure number (slopes)."""
    return Length if name in LENGTHS else Angle if name in ANGLES else Number


def _value_of(name: str) -> Any:
    """The same, within what makes sense for a value."""
    return Annotated[quantity_of(name), Field(gt=0)] if name in ("baseline", "half_angle") else quantity_of(name)


def _known(configuration: str) -> str:
    if configuration not in CONFIGURATIONS:
        raise ValueError(f"it is not known; allowed: {', '.join(CONFIGURATIONS)}")
    return configuration


class Heading(Document):
    """Read first: what the other tables may hold depends on it."""

    model_config = ConfigDict(extra="ignore")

    format: Literal["calibore-rig/1"]
    configuration: Annotated[str, AfterValidator(_known)] | None = None
    camera: Any = None
    laser: Any = None


class PortTable(Document):
    thickness: Annotated[Length, Field(gt=0)]
    index: Positive
    distance: Annotated[Length, Field(ge=0)] = 0.0
    medium_index: Positive = 1.0


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
    pupil_walk: tuple[Length, ...] = ()
    port: PortTable | None = None


class LaserTable(Document):
    """What every laser may say; the keys of its surface come from the configuration."""

    channel: Literal["red", "green", "blue", "luma"] | None = None
    takes: Annotated[tuple[Annotated[int, Strict()], ...], Field(min_length=1)] | None = None


class CorrelationTable(Document):
    between: tuple[str, str]
    coefficient: Annotated[Number, Field(ge=-1, le=1)]


class ValidTable(Document):
    zenith: tuple[Angle, Angle] | None = None
    radius: tuple[Length, Length] | None = None


class CalibrationTable(Document):
    """What a rig needs of its calibration is checked; the rest is for people and for `calibore.calibration`."""

    parameters: tuple[str, ...] = ()
    covariance: tuple[tuple[Number, ...], ...] = ()
    degrees_of_freedom: Positive | None = None
    parameter_degrees_of_freedom: tuple[Annotated[float, Field(gt=0, allow_inf_nan=True)], ...] | None = None
    evidence: str | None = None
    valid: ValidTable | None = None
    kind: str | None = None
    created_by: Any = None
    values: Any = None
    unit: Any = None
    noise: Any = None
    group_sigma: Any = None
    findings: Any = None
    warnings: Any = None
    model: Any = None
    file: Any = None
    settings: Any = None


Shape = Literal["normal", "rectangular", "triangular", "arcsine"]


def _stated(quantity: Any, name: str) -> Any:
    """A standard uncertainty: a number, or a table with `u` or `limits` (half width), distribution and degrees of
    freedom.
    """
    least: Any = Annotated[quantity, Field(ge=0, le=LARGEST)]
    freedom: Any = Positive
    keys: dict[str, Any] = {
        "u": (least | None, None),
        "limits": (least | None, None),
        "distribution": (Shape | None, None),
        "degrees_of_freedom": (freedom | None, None),
    }
    table: Any = create_model(f"Uncertainty of {name}", __base__=Document, **keys)
    return Annotated[
        Annotated[table, Tag(UNNAMED + "table")] | Annotated[least, Tag(UNNAMED + "number")],
        Discriminator(lambda value: UNNAMED + ("table" if isinstance(value, dict) else "number")),
    ]


def laser_keys(configuration: Configuration) -> dict[str, float | None]:
    """Keys of the configuration's laser table with their defaults, None where a key is needed."""
    fixed = dict(configuration.fixed)
    own: Any = configuration.surface
    defaults = {field.name: field.default for field in fields(own) if field.name not in fixed}
    keys = {name: None if default is MISSING else float(default) for name, default in defaults.items()}
    if configuration.side_facing:
        keys = {"baseline": None, "aim": None, **keys}
    if configuration.reversed:
        keys["offset"] = None
    return keys


CAMERA_INPUTS = ("k", "c1", "c2", "aspect", "principal_point")


@lru_cache(maxsize=16)
def rig_file(configuration: Configuration, *, listed: bool) -> type[Document]:
    """The model of a rig file of this configuration, its lasers in one [laser] or in `listed` [[laser]] tables."""
    keys = laser_keys(configuration)
    values: dict[str, Any] = {
        name: (_value_of(name), ...) if default is None else (_value_of(name), default)
        for name, default in keys.items()
    }
    laser: Any = create_model("LaserTable", __base__=LaserTable, **values)
    if listed:
        least, most = configuration.lasers
        laser = Annotated[tuple[laser, ...], Field(min_length=least, max_length=most)]
    return _file(tuple(keys), configuration=(str, ...), laser=(laser, ...))


@lru_cache(maxsize=1)
def camera_file() -> type[Document]:
    """The model of a rig file that holds a camera only."""
    return _file(())


def _file(keys: tuple[str, ...], **tables: Any) -> type[Document]:
    inputs = _inputs(keys)
    stripe: Any = Annotated[Number, Field(ge=0)]
    beside: dict[str, Any] = {"stripe": (stripe | None, None), "correlation": (tuple[CorrelationTable, ...], ())}
    uncertainty: Any = create_model("UncertaintyTable", __base__=Document, **inputs, **beside)
    drift: Any = create_model("DriftTable", __base__=Document, **inputs)
    return create_model(
        "RigFile",
        __base__=Document,
        format=(str, ...),
        camera=(CameraTable, ...),
        **tables,
        uncertainty=(uncertainty, uncertainty()),
        calibration=(CalibrationTable | None, None),
        drift=(drift, drift()),
    )


def _inputs(keys: tuple[str, ...]) -> dict[str, Any]:
    """Whose standard uncertainty, or drift, a rig file may state: those of the laser's `keys`, and the camera's."""
    inputs: dict[str, Any] = {name: (_stated(quantity_of(name), name) | None, None) for name in keys}
    inputs |= {name: (_stated(Number, name) | None, None) for name in CAMERA_INPUTS}
    port = {"port_thickness": Length, "port_index": Number, "port_distance": Length, "port_medium_index": Number}
    inputs |= {name: (_stated(quantity, name) | None, None) for name, quantity in port.items()}
    return inputs | {"pupil_walk": (tuple[Annotated[Length, Field(ge=0)], ...], ())}

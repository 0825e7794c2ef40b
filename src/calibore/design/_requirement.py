"""What a rig is wanted for: the pipe, the accuracy, the crawler it must fit, the cameras there are."""

from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, Field, Strict, StringConstraints, model_validator

from calibore.documents import Angle, Document, Length, read_document
from calibore.errors import InputError
from calibore.units import parse_quantity

DEFAULT_CONFIGURATIONS = ("perpendicular-plane", "single-cone", "dual-cone", "side-facing")
FINEST, COARSEST = 4, 64
"""Steps of the search for each length."""


class Amount(NamedTuple):
    """A length [m], or a share of the nominal radius."""

    value: float
    is_share: bool

    def at(self, nominal_radius: float) -> float:
        """In metres."""
        return self.value * nominal_radius if self.is_share else self.value


def _percent(value: Any) -> float:
    text = value.strip() if isinstance(value, str) else ""
    if not text.endswith("%"):
        raise ValueError(f'it must be text in per cent, such as "10 %", got {value!r}')
    try:
        return float(text[:-1]) / 100
    except ValueError as error:
        raise ValueError('it must be one number with a decimal point and the sign %, such as "10 %"') from error


def _amount(value: Any) -> Amount:
    if isinstance(value, str) and value.strip().endswith("%"):
        return Amount(_percent(value), is_share=True)
    if not isinstance(value, str):
        raise ValueError(f'it must be a length such as "1 mm" or a share of the radius such as "1 %", got {value!r}')
    try:
        return Amount(parse_quantity(value, "length"), is_share=False)
    except InputError as error:
        raise ValueError(str(error)) from error


def _positive(amount: Amount) -> Amount:
    if not 0 < amount.value < np.inf:
        raise ValueError("it must be greater than 0")
    return amount


Percent = Annotated[float, BeforeValidator(_percent)]
LengthOrPercent = Annotated[Amount, BeforeValidator(lambda value: _positive(_amount(value)))]
PositiveLength = Annotated[Length, Field(gt=0)]
Number = Annotated[float, Strict(), Field(gt=0)]
Whole = Annotated[int, Strict(), Field(gt=0)]
HalfTurn = Annotated[Angle, Field(gt=0, lt=2 * np.pi)]
Text = Annotated[str, StringConstraints(min_length=1, max_length=80)]
LensName = Literal["perspective", "stereographic", "equidistant", "sine-law", "equisolid-angle"]
Searched = Literal[
    "perpendicular-plane",
    "single-cone",
    "dual-cone",
    "side-facing",
    "coaxial-cone",
    "asymmetric-cone",
    "reversed-cone",
    "rotating-spot",
]


class PipeTable(Document):
    """`radius` (least, most), or `nominal_radius` with a `tolerance`."""

    radius: tuple[PositiveLength, PositiveLength] | None = None
    nominal_radius: PositiveLength | None = None
    tolerance: Percent | None = None

    @model_validator(mode="after")
    def _says_one_range(self) -> Self:
        if (self.radius is None) == (self.nominal_radius is None):
            raise ValueError('it must have either radius = ["least", "most"] or nominal_radius, with its tolerance')
        if self.radius and not self.radius[0] < self.radius[1]:
            raise ValueError("radius must be [least, most], the least first")
        if self.radius and self.tolerance is not None:
            raise ValueError("tolerance belongs to nominal_radius; radius already says the range")
        if self.tolerance is not None and not 0 < self.tolerance < 1:
            raise ValueError("tolerance must lie between 0 and 100 %")
        return self


class RequirementTable(Document):
    """`u95` of a radius; `deflection` that must still be measured; `coverage` of the circumference; `occlusion`: least
    angle between wall and ray.
    """

    u95: LengthOrPercent
    deflection: Annotated[Percent, Field(ge=0, lt=1)] | None = None
    coverage: Annotated[Percent, Field(gt=0, le=1)] = 1.0
    occlusion: Annotated[Angle, Field(gt=0, lt=np.pi / 2)] | None = None


class BodyTable(Document):
    """A cylinder: the crawler's envelope, or the housing of a laser."""

    length: PositiveLength
    diameter: PositiveLength


class CameraChoice(Document):
    """A camera with its `lenses` and their scales: any, or one of the four ways to say which. Field of view: the whole
    angle across the longer side.
    """

    name: Text
    width: Whole
    height: Whole
    body_length: PositiveLength
    body_diameter: PositiveLength
    lenses: Annotated[tuple[LensName, ...], Field(min_length=1)]
    k: Annotated[tuple[Number, ...], Field(min_length=1)] | None = None
    k_range: tuple[Number, Number] | None = None
    field_of_view: Annotated[tuple[HalfTurn, ...], Field(min_length=1)] | None = None
    field_of_view_range: tuple[HalfTurn, HalfTurn] | None = None

    @model_validator(mode="after")
    def _says_scale_once(self) -> Self:
        said = [name for name in ("k", "k_range", "field_of_view", "field_of_view_range") if getattr(self, name)]
        if len(said) > 1:
            raise ValueError(f"{' and '.join(said)} say the same thing; keep one of them")
        for name in ("k_range", "field_of_view_range"):
            limits = getattr(self, name)
            if limits and not limits[0] < limits[1]:
                raise ValueError(f"{name} must be [least, most], the least first")
        return self


class NoiseTable(Document):
    """`stripe` [px]: standard uncertainty of a line position; `length`: every length is built to within this."""

    stripe: Annotated[float, Strict(), Field(ge=0)]
    length: LengthOrPercent


class SearchTable(Document):
    """Which configurations, how finely, and between which baselines and projections."""

    configurations: Annotated[tuple[Searched, ...], Field(min_length=1)] = DEFAULT_CONFIGURATIONS
    steps: Annotated[int, Strict(), Field(ge=FINEST, le=COARSEST)] = 16
    baseline: tuple[PositiveLength, PositiveLength] | None = None
    projection: tuple[PositiveLength, PositiveLength] | None = None


class Requirement(Document):
    """A requirement file, format calibore-design/1; lengths in metres, angles in radians."""

    format: Literal["calibore-design/1"]
    name: Text = "rig"
    pipe: PipeTable
    requirement: RequirementTable
    crawler: BodyTable
    laser: BodyTable
    camera: Annotated[tuple[CameraChoice, ...], Field(min_length=1)]
    noise: NoiseTable
    search: SearchTable = SearchTable()

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        names = [camera.name for camera in self.camera]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f'the name "{twice[0]}" is given to two cameras; names tell them apart')
        if self.crawler.diameter / 2 >= self.radii[1]:
            raise ValueError(
                f"crawler.diameter of {self.crawler.diameter:.4g} m does not pass a pipe of radius {self.radii[1]:.4g} "
                "m; give the envelope in the units of the pipe"
            )
        return self

    @property
    def radii(self) -> tuple[float, float]:
        """Least and most radius of the pipe [m]."""
        if self.pipe.radius:
            return self.pipe.radius
        nominal, tolerance = self.pipe.nominal_radius or 0.0, self.pipe.tolerance or 0.0
        return nominal * (1 - tolerance), nominal * (1 + tolerance)

    @property
    def nominal_radius(self) -> float:
        """[m]: the stated one, or the middle of the range."""
        return self.pipe.nominal_radius or sum(self.radii) / 2

    @property
    def budget(self) -> float:
        """Largest U95 of a radius [m]."""
        return self.requirement.u95.at(self.nominal_radius)

    @property
    def smallest_wanted(self) -> float:
        """Radius [m] that must still be measured: the deflected pipe's, or the least of the range."""
        deflection = self.requirement.deflection
        return min(self.radii[0], self.nominal_radius * (1 - deflection)) if deflection else self.radii[0]


def read_requirement(path: Path | str) -> Requirement:
    """The requirement file `path`; raises InputError naming file, key, value and what is allowed."""
    return read_document(Path(path), Requirement)

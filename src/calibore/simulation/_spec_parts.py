"""Tables of a simulation's specification that describe parts of the wall."""

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Strict

from calibore.documents import Angle, Document, Length
from calibore.scans import read_profile
from calibore.simulation._damage import ConicalProtrusion, Corrugation, Crack, MeasuredWall
from calibore.simulation._parts import (
    Dent,
    Harmonic,
    LateralOpening,
    OffsetJoint,
    Ovality,
    Rail,
    Roughness,
    WallPart,
)

Number = Annotated[float, Strict()]
Count = Annotated[int, Strict(), Field(ge=0)]
MOST = 100_000
Several = Annotated[int, Strict(), Field(ge=1, le=MOST)]
"""Stations, stops, takes: as many as somebody could wait for, and memory holds."""


class _Part(Document):
    makes: ClassVar[type[WallPart]]

    def part(self, folder: Path) -> WallPart:
        """The part of the wall; files relative to `folder`."""
        return self.makes(**self.model_dump(exclude={"kind"}, exclude_none=True))


class OvalityTable(_Part):
    makes = Ovality
    kind: Literal["ovality"]
    percent: tuple[Number, Number]
    axial: tuple[Length, Length] = (0.0, 1.0)
    axis: Angle = Ovality.axis


class HarmonicTable(_Part):
    makes = Harmonic
    kind: Literal["harmonic"]
    order: Count
    amplitude: Length
    axis: Angle = 0.0


class DentTable(_Part):
    makes = Dent
    kind: Literal["dent"]
    depth: Length
    clock: Angle
    axial: Length
    clock_width: Angle
    length: Length


class ConeTable(_Part):
    makes = ConicalProtrusion
    kind: Literal["cone"]
    height: Length
    base_radius: Length
    top_radius: Length
    clock: Angle
    axial: Length
    edge: Length = ConicalProtrusion.edge


class RailTable(_Part):
    makes = Rail
    kind: Literal["rail"]
    height: Length
    width: Length
    clock: Angle = Rail.clock
    axial: tuple[Length, Length] | None = None
    edge: Length = Rail.edge


class LateralTable(_Part):
    makes = LateralOpening
    kind: Literal["lateral"]
    radius: Length
    depth: Length
    clock: Angle
    axial: Length
    edge: Length = LateralOpening.edge


class JointTable(_Part):
    makes = OffsetJoint
    kind: Literal["joint"]
    offset: Length
    clock: Angle
    axial: Length
    edge: Length = OffsetJoint.edge


class CrackTable(_Part):
    makes = Crack
    kind: Literal["crack"]
    width: Length
    depth: Length
    axial: tuple[Length, Length]
    clock: tuple[Angle, Angle]
    edge: Length = Crack.edge


class CorrugationTable(_Part):
    makes = Corrugation
    kind: Literal["corrugation"]
    amplitude: Length
    pitch: Length
    crest: Length = 0.0


class RoughnessTable(_Part):
    makes = Roughness
    kind: Literal["roughness"]
    rms: Length
    grain: Length = 0.003
    seed: Count = 0


class MeasuredTable(_Part):
    kind: Literal["measured"]
    profile: str

    def part(self, folder: Path) -> WallPart:
        """As measured before."""
        return MeasuredWall(read_profile(folder / self.profile))


PartTable = Annotated[
    OvalityTable
    | HarmonicTable
    | DentTable
    | ConeTable
    | RailTable
    | LateralTable
    | JointTable
    | CrackTable
    | CorrugationTable
    | RoughnessTable
    | MeasuredTable,
    Field(discriminator="kind"),
]

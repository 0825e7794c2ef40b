"""Tables of a simulation's specification that describe parts of the wall."""

from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Literal

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


class _Part(Document):
    @abstractmethod
    def part(self, folder: Path) -> WallPart:
        """The part, files relative to `folder`."""


def _made(kind: type[WallPart], document: Document) -> WallPart:
    return kind(**document.model_dump(exclude={"kind"}))


class OvalityTable(_Part):
    kind: Literal["ovality"]
    percent: tuple[Number, Number]
    axial: tuple[Length, Length] = (0.0, 1.0)
    axis: Angle = Ovality.axis

    def part(self, folder: Path) -> WallPart:
        return _made(Ovality, self)


class HarmonicTable(_Part):
    kind: Literal["harmonic"]
    order: Count
    amplitude: Length
    axis: Angle = 0.0

    def part(self, folder: Path) -> WallPart:
        return _made(Harmonic, self)


class DentTable(_Part):
    kind: Literal["dent"]
    depth: Length
    clock: Angle
    axial: Length
    clock_width: Angle
    length: Length

    def part(self, folder: Path) -> WallPart:
        return _made(Dent, self)


class ConeTable(_Part):
    kind: Literal["cone"]
    height: Length
    base_radius: Length
    top_radius: Length
    clock: Angle
    axial: Length
    edge: Length = ConicalProtrusion.edge

    def part(self, folder: Path) -> WallPart:
        return _made(ConicalProtrusion, self)


class RailTable(_Part):
    kind: Literal["rail"]
    height: Length
    width: Length
    clock: Angle = Rail.clock
    axial: tuple[Length, Length] | None = None
    edge: Length = Rail.edge

    def part(self, folder: Path) -> WallPart:
        return Rail(**self.model_dump(exclude={"kind"}, exclude_none=True))


class LateralTable(_Part):
    kind: Literal["lateral"]
    radius: Length
    depth: Length
    clock: Angle
    axial: Length
    edge: Length = LateralOpening.edge

    def part(self, folder: Path) -> WallPart:
        return _made(LateralOpening, self)


class JointTable(_Part):
    kind: Literal["joint"]
    offset: Length
    clock: Angle
    axial: Length
    edge: Length = OffsetJoint.edge

    def part(self, folder: Path) -> WallPart:
        return _made(OffsetJoint, self)


class CrackTable(_Part):
    kind: Literal["crack"]
    width: Length
    depth: Length
    axial: tuple[Length, Length]
    clock: tuple[Angle, Angle]
    edge: Length = Crack.edge

    def part(self, folder: Path) -> WallPart:
        return _made(Crack, self)


class CorrugationTable(_Part):
    kind: Literal["corrugation"]
    amplitude: Length
    pitch: Length
    crest: Length = 0.0

    def part(self, folder: Path) -> WallPart:
        return _made(Corrugation, self)


class RoughnessTable(_Part):
    kind: Literal["roughness"]
    rms: Length
    grain: Length = 0.003
    seed: Count = 0

    def part(self, folder: Path) -> WallPart:
        return _made(Roughness, self)


class MeasuredTable(_Part):
    kind: Literal["measured"]
    profile: str

    def part(self, folder: Path) -> WallPart:
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

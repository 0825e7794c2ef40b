"""Tables of a simulation's specification that describe what pictures suffer from: dirt, water, glare, codecs."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict

from calibore.documents import Angle, Document, Length
from calibore.simulation._encoding import Film, Still
from calibore.simulation._finish import Finish
from calibore.simulation._lamp import Lamp, Overlay
from calibore.simulation._soiling import Band, Deposit, Patch, Specks, Stain
from calibore.simulation._spec_parts import Count, Number
from calibore.simulation._water import Water
from calibore.simulation._window import Ghost, Smudge, Window


class _Stain(Document):
    makes: ClassVar[type[Stain]]

    def stain(self) -> Stain:
        return self.makes(**self.model_dump(exclude={"kind"}))


class PatchTable(_Stain):
    makes = Patch
    kind: Literal["patch"]
    clock: Angle
    axial: Length
    radius: Length
    reflectance: Number = Patch.reflectance
    edge: Length = Patch.edge
    height: Length = 0.0


class BandTable(_Stain):
    makes = Band
    kind: Literal["band"]
    axial: tuple[Length, Length]
    reflectance: Number = Band.reflectance
    edge: Length = Band.edge


class SpecksTable(_Stain):
    makes = Specks
    kind: Literal["specks"]
    spacing: Length
    radius: Length
    reflectance: Number = Specks.reflectance
    seed: Count = 0


StainTable = Annotated[PatchTable | BandTable | SpecksTable, Field(discriminator="kind")]


class FinishTable(Document):
    reflectance: Number = Finish.reflectance
    contrast: Number = Finish.contrast
    grain: Length = Finish.grain
    seed: Count = 0
    specular: Number = Finish.specular
    gloss: Number = Finish.gloss
    stains: tuple[StainTable, ...] = ()

    def finish(self) -> Finish:
        """The finish of the wall."""
        plain: dict[str, Any] = self.model_dump(exclude={"stains"})
        return Finish(**plain, stains=tuple(table.stain() for table in self.stains))

    def deposits(self) -> tuple[Deposit, ...]:
        """The parts of the wall where its stains stand up."""
        stains = (table.stain() for table in self.stains)
        return tuple(Deposit(stain) for stain in stains if isinstance(stain, Patch) and stain.height > 0)


class WaterTable(Document):
    level: Length
    ripple: Angle = Water.ripple
    glints: Number = 0.0
    seed: Count = 0

    def water(self) -> Water:
        """The water in the pipe."""
        return Water(**self.model_dump())


class _Smudge(Document):
    u: Number
    v: Number
    radius: Number
    transmission: Number = Smudge.transmission


class _Ghost(Document):
    strength: Number
    scale: Number = 1.0
    shift: tuple[Number, Number] = (0.0, 0.0)


class WindowTable(Document):
    smudges: tuple[_Smudge, ...] = ()
    ghosts: tuple[_Ghost, ...] = ()
    halo: Number = 0.0
    halo_sigma: Number = Window.halo_sigma

    def window(self) -> Window:
        """What the camera looks through."""
        smudges = tuple(Smudge(**table.model_dump()) for table in self.smudges)
        ghosts = tuple(Ghost(**table.model_dump()) for table in self.ghosts)
        return Window(smudges, ghosts, self.halo, self.halo_sigma)


class LampTable(Document):
    distance: Length
    clock: Angle = Lamp.clock
    width: Angle = Lamp.width
    length: Length = Lamp.length
    brightness: Number = Lamp.brightness

    def lamp(self) -> Lamp:
        """The lamp."""
        return Lamp(**self.model_dump())


class OverlayTable(Document):
    text: str
    u: Number = Overlay.u
    v: Number = Overlay.v
    height: Number = Overlay.height
    brightness: Number = Overlay.brightness

    def overlay(self) -> Overlay:
        """The text in the pictures."""
        return Overlay(**self.model_dump())


class _Video(Document):
    codec: str = Film.codec
    rate: Annotated[int, Strict()] = Film.rate
    quality: Annotated[int, Strict()] = Film.quality
    chroma: str = Film.chroma


class ImagesTable(Document):
    format: str = Still.format
    quality: Annotated[int, Strict()] = Still.quality
    chroma: str = Still.chroma
    video: _Video | None = None

    def storage(self) -> Still | Film:
        """How pictures are stored."""
        if self.video is not None:
            return Film(**self.video.model_dump())
        return Still(self.format, self.quality, self.chroma)

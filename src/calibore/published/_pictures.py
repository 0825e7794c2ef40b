"""What a table or figure of the source shows, as data: panels of curves or maps, and what its text says of it."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Style = Literal["solid", "dashed", "dotted", "dash-dot"]
Tone = Literal["blue", "red", "green", "purple", "black", "grey", "orange"]


class Region(IntEnum):
    """What a pixel of a map is."""

    MEASURED = 0
    COMPLEX = 1
    NEGATIVE = 2
    UNSEEN = 3
    GRAZING = 4


@dataclass(frozen=True, eq=False)
class Curve:
    """`x`, `y` (n,) with a `label`, empty for none; `right`: of the scale on the right."""

    x: Array
    y: Array
    label: str = ""
    tone: Tone = "blue"
    style: Style = "solid"
    right: bool = False


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves over one axis; `bands` of x are shaded and named, `equal`: both axes have one scale, as in an image."""

    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    title: str = ""
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float, float] | None = None
    right_label: str = ""
    right_limits: tuple[float, float] | None = None
    bands: tuple[tuple[float, float], ...] = ()
    band_label: str = ""
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Level:
    """The line where `values` (h, w) of a map take the value `at`."""

    values: Array
    at: float
    label: str
    tone: Tone = "black"
    style: Style = "solid"


@dataclass(frozen=True, eq=False)
class Map:
    """`values` (h, w) over `x` (w,) and `y` (h,), coloured from `low` to `high`; values above `high` are white.
    `regions` (h, w) say where there is none; `levels` and `lines` are drawn over it. `bar` labels its own colour bar;
    without it the picture has one for all.
    """

    x: Array
    y: Array
    values: Array
    regions: NDArray[np.uint8]
    low: float
    high: float
    levels: tuple[Level, ...] = ()
    lines: tuple[Curve, ...] = ()
    title: str = ""
    bar: str = ""

    @property
    def has_above(self) -> bool:
        """Whether values lie above the colours."""
        measured = self.values[self.regions == Region.MEASURED]
        return bool((measured > self.high * (1 + 1e-9)).any())


Panel = Chart | Map


@dataclass(frozen=True)
class Claim:
    """What the text `says` of a picture, whether it `holds` (None: in part, or a matter of words) and `ours`."""

    says: str
    holds: bool | None
    ours: str


@dataclass(frozen=True, eq=False)
class Picture:
    """A table or figure: `name` of its files, `title`, `panels` by rows, names of rows and columns of a table.

    `bar`: label of the one colour bar of all maps; `axes`: labels of x and y of all maps. `note`: what was assumed
    because the text does not say it, and where we deviate on purpose.
    """

    name: str
    title: str
    panels: tuple[tuple[Panel, ...], ...]
    note: str
    claims: tuple[Claim, ...] = ()
    rows: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    bar: str = ""
    axes: tuple[str, str] = ("", "")


def single(name: str, title: str, chart: Chart, *, note: str, claims: tuple[Claim, ...] = ()) -> Picture:
    """A picture of one panel."""
    return Picture(name, title, ((chart,),), note, claims)


def every(condition: ArrayLike) -> bool:
    """Whether all of it is true, as a plain bool."""
    return bool(np.all(condition))

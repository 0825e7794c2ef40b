"""What every source of pictures offers: stations one after the other, and what it had to leave out."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8] | NDArray[np.uint16]
"""shape (h, w) or (h, w, 3), red green blue; indexed `[v, u]`."""


@dataclass(frozen=True)
class PictureFile:
    """Where a picture is, and the most bytes that it may have."""

    path: Path
    limit: int


@dataclass(frozen=True)
class StationImages:
    """The pictures taken at one station.

    `read(take)` gives the pixels of one of `takes`, or raises ImageError for this image alone; it may be called from
    any thread, and for folders that is where the decoding happens. `names`: each take as a person would look for it.
    `files`: where each take is, if it is a file that the compiled code reads by itself.
    """

    station: int
    takes: tuple[int, ...]
    read: Callable[[int], Pixels]
    time_s: float | None = None
    angular: int = 0
    names: tuple[str, ...] = ()
    files: tuple[PictureFile, ...] = ()

    def file(self, take: int) -> PictureFile | None:
        """Where one of `takes` is, None where it is no such file."""
        return dict(zip(self.takes, self.files, strict=False)).get(take)

    def name(self, take: int) -> str:
        """The file name of one of `takes`, or what else its picture is called."""
        return dict(zip(self.takes, self.names, strict=False)).get(take, f"station {self.station}, take {take}")


@dataclass(frozen=True)
class Refusal:
    """`count` pictures that a source could not hand out, the first of them at `station`, all for the same reason."""

    reason: str
    count: int
    station: int

    def __str__(self) -> str:
        pictures = "1 frame" if self.count == 1 else f"{self.count} frames"
        return f"{pictures} left out, the first is frame {self.station}: {self.reason}."


class ImageSource(Protocol):
    """Iterates in order of station; every call of `stations` starts again from the first."""

    @property
    def expected_stations(self) -> int | None:
        """How many stations there are, for progress; None where only reading to the end would tell."""
        ...

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """What the latest iteration has left out so far."""
        ...

    def stations(self) -> Iterator[StationImages]: ...

"""Everything that becomes of a run, in order, whether it is measured now or comes from the journal of a killed run."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TextIO

from calibore.acquisition._backlog import LeftOut
from calibore.acquisition._journal import Arrays, Journal
from calibore.acquisition._ring import KeptRing
from calibore.errors import InputError
from calibore.images import Pixels, Refusal, StationImages
from calibore.profiling import RefusedImage, Tally
from calibore.scans import ResultWriter

LEFT_OUT = "left_out.csv"


@dataclass
class Book:
    """Counts, stores and remembers what a run has measured and left out."""

    writer: ResultWriter
    journal: Journal
    tally: Tally = field(default_factory=Tally)
    dropped: int = 0
    refused: int = 0
    last_station: int | None = None
    last_time: float = float("nan")
    began: float | None = None
    dropped_between: tuple[float, float] | None = None
    _reasons: dict[str, tuple[int, int]] = field(default_factory=dict)
    _unplaced: list[tuple[int, int]] = field(default_factory=list)
    _table: TextIO | None = None

    def replay(self) -> int:
        """What the journal holds, as if it came now; returns the number of rings."""
        for header, arrays in self.journal.records():
            _REPLAY[header["kind"]](self, header, arrays)
        return self.tally.stations

    def begin(self, unix: float) -> None:
        """The first picture came at this Unix time [s]."""
        self.journal.add({"kind": "began", "unix": unix})
        self.began = unix

    def add_ring(self, ring: KeptRing) -> None:
        header, arrays = ring.record()
        self.journal.add(header, arrays)
        self._ring(ring)

    def _ring(self, ring: KeptRing) -> None:
        self._see(ring.profile.station, ring.takes, timed=ring.timed)
        self.last_time = ring.profile.time_s
        self.tally.add_images(ring)
        self.tally.add_ring(ring.profile, ring.quantities, ring.row)
        self.writer.add(ring.profile, ring.points, ring.row)
        self.refused += len(ring.refused)

    def add_refused(self, images: StationImages, refused: Sequence[RefusedImage]) -> None:
        """A station of which no picture could be used."""
        timed, names = images.time_s is not None, [[image.name, image.reason] for image in refused]
        record = {"kind": "refused", "station": images.station, "takes": images.takes, "timed": timed}
        self.journal.add({**record, "refused": names})
        self._refused(images.station, images.takes, refused, timed=timed)

    def _refused(self, station: int, takes: Sequence[int], refused: Sequence[RefusedImage], *, timed: bool) -> None:
        self._see(station, takes, timed=timed)
        self.tally.refuse(refused)
        self.refused += len(refused)

    def add_unplaced(self, images: StationImages) -> None:
        """A station of which nobody knows where it lies."""
        timed = images.time_s is not None
        self.journal.add({"kind": "unplaced", "station": images.station, "takes": images.takes, "timed": timed})
        self._unplaced_one(images.station, images.takes, timed=timed)

    def _unplaced_one(self, station: int, takes: Sequence[int], *, timed: bool) -> None:
        self._see(station, takes, timed=timed)
        self._unplaced.append((station, len(takes)))
        self.refused += len(takes)

    def leave_out(self, one: LeftOut) -> None:
        """Pictures that were dropped, or refused before anybody measured them."""
        self.journal.add({"kind": "left out", **vars(one)})
        self._left_out(one)

    def _left_out(self, one: LeftOut) -> None:
        self._highest(one.station + one.count - 1)
        if one.refused:
            count, first = self._reasons.get(one.why, (0, one.station))
            self._reasons[one.why] = count + one.count, first
            self.refused += one.count
        else:
            self.dropped += one.count
            first_time, _ = self.dropped_between or (one.time_s, one.time_s)
            self.dropped_between = first_time, one.time_s
        self._write(one)

    def _write(self, one: LeftOut) -> None:
        if self._table is None:
            self._table = (self.writer.folder / LEFT_OUT).open("w", encoding="utf-8", newline="")
            csv.writer(self._table, lineterminator="\n").writerow(["station", "time_s", "count", "why"])
        row = [one.station, repr(one.time_s), one.count, one.why]
        csv.writer(self._table, lineterminator="\n").writerow(row)

    def _see(self, station: int, takes: Sequence[int], *, timed: bool) -> None:
        self._highest(station)
        self.tally.see(StationImages(station, tuple(takes), _gone, time_s=0.0 if timed else None))

    def _highest(self, station: int) -> None:
        self.last_station = station if self.last_station is None else max(station, self.last_station)

    def close(self, expected: Sequence[int] = ()) -> None:
        """Everything was told: what was left out goes into the tally."""
        refusals = [Refusal(why, count, first) for why, (count, first) in self._reasons.items()]
        self.tally.leave_out(self._unplaced, refusals, expected=expected)
        self.close_table()

    def close_table(self) -> None:
        if self._table is not None:
            self._table.close()


def _gone(take: int) -> Pixels:
    raise InputError(f"The picture of take {take} is not kept.")


def _images(header: Mapping[str, Any]) -> dict[str, Any]:
    return {"station": header["station"], "takes": header["takes"], "timed": header["timed"]}


def _replay_began(book: Book, header: Mapping[str, Any], arrays: Arrays) -> None:
    book.began = header["unix"]


_REPLAY = {
    "run": lambda book, header, arrays: None,
    "began": _replay_began,
    "ring": lambda book, header, arrays: book._ring(KeptRing.from_record(header, arrays)),
    "refused": lambda book, header, arrays: book._refused(
        refused=[RefusedImage(*image) for image in header["refused"]], **_images(header)
    ),
    "unplaced": lambda book, header, arrays: book._unplaced_one(**_images(header)),
    "left out": lambda book, header, arrays: book._left_out(
        LeftOut(**{name: header[name] for name in ("station", "time_s", "why", "refused", "count")})
    ),
}

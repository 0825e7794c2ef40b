"""Where the rig was when a live picture was taken."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from calibore.errors import InputError
from calibore.images import Odometry, StationImages
from calibore.profiling import Placement, Placer, placed_by_station
from calibore.scans import ScanSpec
from calibore.units import parse_quantity

WAITED = 1.0
"""Seconds that a picture waits for a row of the odometry after it."""
UNIX = 1e8
"""Times [s] beyond this are Unix times, not times since the first picture."""
COLUMNS = ("time_s", "axial_m", "roll_rad")


def speed_of(text: str) -> float:
    """`"100 mm/s"` in m/s; raises InputError."""
    length, slash, unit = text.strip().rpartition("/")
    if not slash or unit.strip() != "s":
        raise InputError(f'"{text}" is not a speed such as "100 mm/s" or "4 in/s".')
    return parse_quantity(length, "length")


def placed_by_speed(speed: float) -> Placer:
    """At `speed` [m/s] x time since the first picture; 0 for a rig that stands still."""

    def place(station: StationImages) -> Placement:
        seconds = 0.0 if station.time_s is None else station.time_s
        return Placement(speed * seconds, time=seconds)

    return Placer(place)


def placed_in_folder(spec: ScanSpec) -> Placer:
    """As `calibore profile` places the pictures of `spec`; a station table that grows is read again."""
    placer, state = placed_by_station(spec), _state(spec.motion)

    def place(station: StationImages) -> Placement | None:
        nonlocal placer, state
        found = placer(station)
        if found is None and (current := _state(spec.motion)) != state:
            try:
                placer, state = placed_by_station(spec), current
            except InputError:  # a row that is being written
                return None
            found = placer(station)
        return found

    return Placer(place)


def _state(motion: object) -> tuple[int, int]:
    try:
        found = motion.stat() if isinstance(motion, Path) else None
    except OSError:
        return 0, 0
    return (found.st_size, found.st_mtime_ns) if found else (0, 0)


@dataclass
class LiveOdometry:
    """Placements by an odometry table that may be growing: `time_s,axial_m[,roll_rad]`, times since the first picture
    or Unix times; `began`: the Unix time of the first picture.

    A picture newer than the last row waits a second for the next; a picture that the table does not cover has no place.
    """

    path: Path
    began: Callable[[], float | None]
    _seen: tuple[int, int] = field(default=(-1, -1), init=False)
    _table: Odometry | None = field(default=None, init=False)
    _gone_on_without: tuple[int, int] | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        if not self.path.is_file():
            raise InputError(f"{self.path} does not exist; give an odometry table with the columns time_s,axial_m.")

    def __call__(self, station: StationImages) -> Placement | None:
        seconds = 0.0 if station.time_s is None else station.time_s
        deadline = time.monotonic() + WAITED
        while True:
            self._read_again()
            if self._table is not None:
                moment = seconds + ((self.began() or 0.0) if self._table.time[0] > UNIX else 0.0)
                if self._table.covers(moment):
                    axial, roll = self._table.at(moment)
                    return Placement(float(axial), float(roll), time=seconds)
                if moment < self._table.time[0]:
                    return None
            if self._gone_on_without == self._seen or time.monotonic() > deadline:
                self._gone_on_without = self._seen
                return None
            time.sleep(0.02)

    def _read_again(self) -> None:
        state = _state(self.path)
        if state == self._seen:
            return
        self._seen = state
        lines = self.path.read_text(encoding="utf-8-sig").rpartition("\n")[0].split("\n")
        header = [name.strip() for name in lines[0].split(",")]
        if any(name not in header for name in COLUMNS[:2]):
            raise InputError(f"{self.path} needs the columns time_s,axial_m in its first line; it has {lines[0]!r}.")
        rows = [line.split(",") for line in lines[1:] if line.strip()]
        if len(rows) < 2:
            return
        try:
            table = np.array([[float(row[header.index(n)]) for n in COLUMNS if n in header] for row in rows])
        except (ValueError, IndexError) as error:
            raise InputError(f"{self.path} has a row that is not of numbers ({error}); correct it.") from error
        roll = table[:, 2] if table.shape[1] > 2 else np.zeros(len(table))
        self._table = Odometry(table[:, 0], table[:, 1], roll)

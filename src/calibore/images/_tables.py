"""Tables that say where the pictures were taken: one row per station, or an odometer read against time."""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

STATION_COLUMNS = ("station", "axial_m", "clock_rad", "time_s", "roll_rad", "pitch_rad", "yaw_rad")
ODOMETRY_COLUMNS = ("time_s", "axial_m", "roll_rad")


@dataclass(frozen=True)
class StationRow:
    """Where the rig was at one station, SI."""

    station: int
    axial: float
    clock: float = 0.0
    time: float | None = None
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Odometry:
    """An odometer: axial position [m] and roll [rad] of the rig at increasing times [s], each shape (n,), n >= 2."""

    time: NDArray[np.float64]
    axial: NDArray[np.float64]
    roll: NDArray[np.float64]

    def __post_init__(self) -> None:
        if len(self.time) < 2:
            raise InputError(f"Odometry has {len(self.time)} rows; at least 2 are needed to interpolate.")
        if not self.time.shape == self.axial.shape == self.roll.shape:
            raise InputError(
                "Odometry needs one axial position and one roll for every time; give arrays of the same length."
            )
        if not all(np.isfinite(values).all() for values in (self.time, self.axial, self.roll)):
            raise InputError("Odometry holds NaN or infinity; remove these rows.")
        if not (np.diff(self.time) > 0).all():
            raise InputError("Odometry times must increase; sort the rows and remove repeated times.")

    def covers(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Whether `time` [s] lies within the table."""
        return (np.asarray(time) >= self.time[0]) & (np.asarray(time) <= self.time[-1])

    def at(self, time: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Axial position [m] and roll [rad] at `time` [s], linear between rows; NaN outside the table."""
        seconds = np.asarray(time, dtype=np.float64)
        axial = np.interp(seconds, self.time, self.axial, left=np.nan, right=np.nan)
        return np.asarray(axial), np.asarray(np.interp(seconds, self.time, self.roll, left=np.nan, right=np.nan))


def read_station_table(path: Path) -> dict[int, StationRow]:
    """The rows of a CSV table `station,axial_m[,clock_rad][,time_s][,roll_rad,pitch_rad,yaw_rad]` by station.

    Raises InputError naming file, line and column.
    """
    rows: dict[int, StationRow] = {}
    for line, cells in _rows(path, STATION_COLUMNS, needed=2):
        station = int(cells.pop("station"))
        if station in rows:
            raise InputError(f"{path}, line {line}: station {station} is there twice; keep one row for each station.")
        rows[station] = StationRow(station, **{name.rsplit("_", 1)[0]: value for name, value in cells.items()})
    return rows


def read_odometry(path: Path) -> Odometry:
    """An odometry CSV table `time_s,axial_m[,roll_rad]`; raises InputError naming file, line and column."""
    values: list[tuple[float, float, float]] = []
    for line, cells in _rows(path, ODOMETRY_COLUMNS, needed=2):
        if values and cells["time_s"] <= values[-1][0]:
            raise InputError(
                f"{path}, line {line}: time_s = {cells['time_s']:g} s does not increase (before it: "
                f"{values[-1][0]:g} s); sort the rows by time and remove repeated times."
            )
        values.append((cells["time_s"], cells["axial_m"], cells.get("roll_rad", 0.0)))
    if len(values) < 2:
        raise InputError(f"{path} has {len(values)} row; at least 2 are needed to interpolate.")
    time, axial, roll = np.array(values).T
    return Odometry(time, axial, roll)


def _rows(path: Path, columns: tuple[str, ...], *, needed: int) -> Iterator[tuple[int, dict[str, float]]]:
    """(line number, known columns) of every row; the first `needed` columns must be there."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = [name.strip() for name in next(reader, [])]
            _check_header(path, header, columns, needed)
            empty = True
            for cells in reader:
                if any(cell.strip() for cell in cells):
                    empty = False
                    yield reader.line_num, _numbers(path, reader.line_num, header, cells, columns)
    except FileNotFoundError as error:
        raise InputError(f"{path} does not exist; give the path of an existing table.") from error
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path} cannot be read ({error}); give a table in CSV, UTF-8 encoded.") from error
    if empty:
        raise InputError(f"{path} has a header but no rows; add one row for each station or time.")


def _check_header(path: Path, header: list[str], columns: tuple[str, ...], needed: int) -> None:
    allowed = ", ".join(columns)
    for name in columns[:needed]:
        if name not in header:
            there = ", ".join(header) or "nothing"
            raise InputError(f"{path}: column {name} is missing; the first line names {there}. Columns: {allowed}.")
    stems = {name.split("_")[0]: name for name in columns}
    for name in header:
        known = stems.get(name.lower().split("_")[0])
        if name not in columns and known:  # such as roll_deg: to ignore it would be to ignore the roll
            raise InputError(
                f"{path}: column {name} is not known; write {known} with values in that unit. Columns: {allowed}."
            )
        if header.count(name) > 1 and name in columns:
            raise InputError(f"{path}: column {name} is there twice; keep one.")


def _numbers(path: Path, line: int, header: list[str], cells: list[str], columns: tuple[str, ...]) -> dict[str, float]:
    if len(cells) < len(header):
        raise InputError(
            f"{path}, line {line}: {len(cells)} cells for the {len(header)} columns of line 1; complete the row."
        )
    return {name: _number(path, line, name, cell) for name, cell in zip(header, cells, strict=False) if name in columns}


def _number(path: Path, line: int, column: str, cell: str) -> float:
    try:
        value = int(cell) if column == "station" else float(cell)
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    expected = "a whole number" if column == "station" else "a finite number"
    raise InputError(f'{path}, line {line}: {column} = "{cell.strip()}" is not {expected}; correct that cell.')

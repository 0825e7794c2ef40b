"""Writes a result folder station by station, in flat memory; it appears under its name only when complete."""

import csv
import json
import math
import os
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

import numpy as np

from calibore.scans._layout import (
    POINTS_FORMAT,
    POINTS_PER_CHUNK,
    POINTS_VARIABLES,
    PROFILE_FORMAT,
    PROFILE_VARIABLES,
    STATIONS_PER_CHUNK,
)
from calibore.scans._lock import locked
from calibore.scans._ring import RingPoints, RingProfile
from calibore.scans._scan import ScanSpec
from calibore.scans._staging import (
    RESULT_FORMAT,
    SUMMARY,
    check_destination,
    is_disk_full,
    manifest,
    new_staging,
    publish,
    recover,
    told_as_output_error,
)
from calibore.scans._store import GrowingGroup

Row = Mapping[str, float | int | str]


class ResultWriter:
    """Context manager that makes the result folder `out` of one scan.

    ```
    with ResultWriter(out, spec) as writer:
        writer.add(profile, points, row)      # once per station, stations ascending
        plot(open_profile(writer.seal()))     # optional: more files into writer.folder
        writer.finish(summary)
    ```
    Construction raises OutputError when `out` holds anything but an earlier result of the same scan. Leaving the block
    before `finish`, by an exception, Ctrl-C or a full disk, leaves `out` as it was.
    """

    def __init__(self, out: Path | str, spec: ScanSpec) -> None:
        self._out = Path(os.path.realpath(out))
        self._spec = spec
        self._stack = ExitStack()
        self._folder: Path | None = None
        self._profile: GrowingGroup | None = None
        self._points: GrowingGroup | None = None
        self._rings: _RingTable | None = None
        self._first: RingProfile | None = None
        self._last_station = 0
        with told_as_output_error(self._out):
            check_destination(self._out, spec.identity)

    @property
    def folder(self) -> Path:
        """Where the result is being made; pictures and reports put here become part of it."""
        if self._folder is None:
            raise RuntimeError("A ResultWriter has a folder only inside its with block, before finish().")
        return self._folder

    def __enter__(self) -> "ResultWriter":
        with told_as_output_error(self._out), ExitStack() as stack:
            self._out.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(locked(self._out))
            recover(self._out)
            check_destination(self._out, self._spec.identity)
            stack.callback(recover, self._out)
            self._folder = new_staging(self._out)
            self._rings = _RingTable(stack.enter_context(_text_file(self._folder / "rings.csv")))
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._folder = None
        with told_as_output_error(self._out):
            self._stack.close()
            if error is not None and is_disk_full(error):
                raise error

    def add(self, profile: RingProfile, points: RingPoints, row: Row) -> None:
        """Append one station: its profile, its points and its row of rings.csv (the same keys in every row).

        `station` and `axial_m` are put in front of `row` where it lacks them. Raises ValueError when stations do not
        ascend or clock, modes or keys differ from the first station's, OutputError when the disk is full.
        """
        with told_as_output_error(self._out):
            if self._first is None:
                self._begin(profile)
            if self._profile is None or self._rings is None:
                raise RuntimeError("The result is sealed; add every station before seal() or finish().")
            self._check(profile)
            self._rings.add({"station": profile.station, "axial_m": profile.axial, **row})
            self._profile.append(_profile_block(profile))
            self._begun_points().append(_points_block(points, profile.station))
            self._last_station = profile.station

    def add_points(self, points: RingPoints, station: int) -> None:
        """Append points of `station` that belong to no one row of the profile: where a row is made of many pictures.

        Before or between the rows that `add` takes; those then come with no points. Raises as `add`.
        """
        with told_as_output_error(self._out):
            if self._rings is None:
                raise RuntimeError("The result is sealed; add every point before seal() or finish().")
            self._begun_points().append(_points_block(points, station))

    def seal(self) -> Path:
        """Complete arrays and table; returns `folder`, which `open_profile` and `export` can now read."""
        folder = self.folder
        if self._first is None:
            raise ValueError("No station was added: there is no result to write.")
        with told_as_output_error(self._out):
            for group in (self._profile, self._points):
                if group is not None:
                    group.close()
            if self._rings is not None:
                self._rings.close()
        self._profile = self._points = self._rings = None
        return folder

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write summary.json and give the result its final name.

        `format`, `name`, `identity` and `files` are added to `summary`; non-finite numbers become null.
        """
        folder = self.seal()
        with told_as_output_error(self._out):
            kept = {"format": RESULT_FORMAT, "name": self._spec.name, "identity": self._spec.identity}
            document = {**kept, **summary, **kept, "files": sorted({*manifest(folder), SUMMARY})}
            text = json.dumps(_plain(document), indent=2, ensure_ascii=False, allow_nan=False)
            (folder / SUMMARY).write_text(text + "\n", encoding="utf-8")
            check_destination(self._out, self._spec.identity)
            publish(folder, self._out)
        self._folder = None

    def _begin(self, profile: RingProfile) -> None:
        radius = {"nominal_radius": self._spec.nominal_radius, "nominal_radius_units": "m"}
        self._profile = GrowingGroup(
            self.folder / "profile.zarr",
            PROFILE_VARIABLES,
            growing="station",
            rows=STATIONS_PER_CHUNK,
            sizes={"clock": profile.clock.size, "mode": len(profile.common_mode), "lag": profile.correlation.size},
            attributes={"format": PROFILE_FORMAT, **self._about, **radius},
        )
        self._profile.fill("clock", profile.clock)
        self._first, self._last_station = profile, profile.station - 1

    @property
    def _about(self) -> dict[str, str]:
        about = {"Conventions": "CF-1.11", "title": self._spec.name, "scan_identity": self._spec.identity}
        about["scan_kind"] = self._spec.kind
        return about | ({"scan_date": self._spec.date.isoformat()} if self._spec.date else {})

    def _begun_points(self) -> GrowingGroup:
        self._points = self._points or GrowingGroup(
            self.folder / "points.zarr",
            POINTS_VARIABLES,
            growing="point",
            rows=POINTS_PER_CHUNK,
            sizes={},
            attributes={"format": POINTS_FORMAT, **self._about},
        )
        return self._points

    def _check(self, profile: RingProfile) -> None:
        first = self._first or profile
        if profile.station <= self._last_station:
            raise ValueError(
                f"Station {profile.station} follows {self._last_station}; add stations in ascending order."
            )
        if not np.array_equal(profile.clock, first.clock):
            raise ValueError(f"Station {profile.station} has another clock grid than station {first.station}.")
        if profile.correlation.size != first.correlation.size:
            had = f"{profile.correlation.size} lags, station {first.station} has {first.correlation.size}"
            raise ValueError(f"Station {profile.station} has a noise correlation of {had}; give all the same.")
        if len(profile.common_mode) != len(first.common_mode):
            had = f"{len(profile.common_mode)} common modes, station {first.station} has {len(first.common_mode)}"
            raise ValueError(f"Station {profile.station} has {had}; every station needs the same modes.")


class _RingTable:
    """rings.csv, written row by row; floats with all their digits."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._writer = csv.writer(file, lineterminator="\n")
        self._columns: list[str] | None = None

    def add(self, row: Row) -> None:
        if self._columns is None:
            self._columns = list(row)
            self._writer.writerow(self._columns)
        if list(row) != self._columns:
            raise ValueError(f"A row of rings.csv has columns {list(row)}, the first row had {self._columns}.")
        self._writer.writerow([_plain_cell(value) for value in row.values()])

    def close(self) -> None:
        self._file.close()


def _text_file(path: Path) -> TextIO:
    return path.open("w", encoding="utf-8", newline="")


def _plain_cell(value: float | int | str) -> str:
    if isinstance(value, bool | np.bool_):
        return str(int(value))
    return repr(float(value)) if isinstance(value, float | np.floating) else str(value)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _profile_block(profile: RingProfile) -> dict[str, Any]:
    missing = np.isnan(profile.radius)
    block: dict[str, Any] = {"common_mode": np.where(missing, np.nan, profile.common_mode)[:, np.newaxis, :]}
    for name in ("radius", "axial_position", "u_independent", "u_common"):
        block[name] = np.where(missing, np.nan, getattr(profile, name))[np.newaxis]
    block["status"] = profile.status[np.newaxis]
    block["noise_correlation"] = profile.correlation[np.newaxis]
    for name in ("station", "axial", "centre_x", "centre_y", "u_centre_x", "u_centre_y", "time_s", "roll"):
        block[name] = np.array([getattr(profile, name)])
    return block


def _points_block(points: RingPoints, station: int) -> dict[str, Any]:
    block = {v.name: getattr(points, v.name) for v in POINTS_VARIABLES if v.name != "station"}
    return {**block, "station": np.full(points.x.shape, station)}

"""Every reader of files that a user hands in, and the functions that take numbers: one line each."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from fuzzing import _seeds
from fuzzing._folders import OfFolders
from fuzzing._numbers import Meetings, Stripes
from fuzzing._rings import Rings

DOCUMENT = "document.toml"


def _by(module: str, function: str, name: str = "", **options: Any) -> Callable[[Path], object]:
    """Reader of the file `name` in a folder, or of the folder, which is imported when it is needed."""

    def read(folder: Path) -> object:
        return getattr(import_module(f"calibore.{module}"), function)(folder / name if name else folder, **options)

    read.__name__ = function
    return read


def _archive(folder: Path) -> None:
    from calibore.errors import ImageError
    from calibore.images import ImageArchive

    archive = ImageArchive(folder / "images.zarr", "{station:03d}.png", limit=1 << 20)
    for images in archive.stations():
        for read in (partial(archive.read, images.station), partial(archive.read_band, images.station, channel="red")):
            try:
                pixels = read()
            except ImageError:
                continue
            assert pixels.nbytes <= 1 << 20


def _video(folder: Path) -> None:
    from calibore.errors import ImageError
    from calibore.images import Video

    for channel in ("luma", "red"):
        for images in Video(folder / "video.bin", channel).stations():
            try:
                images.read(0)
            except ImageError:
                continue


def _scan(folder: Path) -> None:
    from calibore.profiling import prepare
    from calibore.scans import read_scan

    _, source, place = prepare(read_scan(folder), estimator="zero-crossing")
    for images in source.stations():
        place(images)


def _result(folder: Path) -> None:
    from calibore.scans import read_profile

    assert np.isfinite(read_profile(folder).axial).all()


def _export(folder: Path) -> None:
    from calibore.scans import export

    for format in ("csv", "text3"):
        export(folder, format, folder.parent / "exported")


def _voltages(folder: Path) -> object:
    from calibore.profiling._tactile._voltages import read_ratio
    from calibore.scans import TactileTables

    return read_ratio(TactileTables(folder / "signal.csv", folder / "bias.csv", 0.001))


SURVEYS = (
    _by("scans", "read_scan", DOCUMENT),
    _by("rigs", "read_rig_or_camera", DOCUMENT),
    _by("rigs", "read_probe", DOCUMENT),
    _by("simulation", "read_subject", DOCUMENT),
    _by("design", "read_requirement", DOCUMENT),
    _by("calibration", "read_planned_target", DOCUMENT),
    _by("calibration._dispatch", "target_of", DOCUMENT),
)
TARGETS = (
    _by("calibration", "read_planned_target"),
    _by("calibration._in_situ._file", "read_profile_target"),
    _by("calibration._rig._gauges_file", "read_gauges_target"),
    _by("calibration._rig._range_file", "read_range_target"),
    _by("calibration._probe._tables", "read_probe_tables"),
    _by("calibration._rings._pictures", "read_ring_pictures"),
    _by("calibration._boards._pictures", "read_board_pictures", "target.toml"),
    _by("calibration._pupil._target", "read_two_pin", "target.toml"),
    _by("calibration._in_situ._file", "read_table", "wall.csv"),
)
TABLES = (
    _by("images", "read_station_table", "stations.csv"),
    _by("images", "read_odometry", "odometry.csv"),
    _voltages,
)
RESULTS = (
    _result,
    _by("scans", "read_rings"),
    _by("scans", "open_points"),
    _export,
    _by("comparison", "kind_of"),
    _by("comparison", "is_tactile_result"),
)
CALIBRATIONS = (
    _by("calibration", "read_calibration", DOCUMENT),
    _by("rigs", "read_probe", DOCUMENT),
    lambda folder: import_module("calibore.calibration").verify_inputs(folder / DOCUMENT, folder),
)

ENTRIES = {
    "documents": OfFolders(_seeds.documents, SURVEYS, (DOCUMENT,)),
    "rigs": OfFolders(_seeds.rigs, (_by("rigs", "read_rig", "rig.toml"), _by("rigs", "read_camera", "rig.toml"))),
    "scans": OfFolders(_seeds.scans, (_scan,), ("scan.toml", "rig.toml")),
    "targets": OfFolders(_seeds.targets, TARGETS, ("*.toml", "*.csv")),
    "calibrations": OfFolders(_seeds.calibrations, CALIBRATIONS, ("*",)),
    "tables": OfFolders(_seeds.tables, TABLES, ("*.csv",)),
    "archives": OfFolders(_seeds.archives, (_archive,), ("*",)),
    "videos": OfFolders(_seeds.videos, (_video,), ("*",)),
    "results": OfFolders(_seeds.results, RESULTS, ("*",)),
    "stripes": Stripes(),
    "meetings": Meetings(),
    "rings": Rings(),
}

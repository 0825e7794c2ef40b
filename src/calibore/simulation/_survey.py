"""A whole scan with its truth: what is driven through which pipe, and the folder that comes of it."""

import os
import shutil
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from calibore.errors import InputError, OutputError
from calibore.geometry import Pose
from calibore.rigs import Rig
from calibore.simulation._files import rig_toml, scan_toml, write_png
from calibore.simulation._light import LineLight, LitLine, lit_line
from calibore.simulation._picture import photograph
from calibore.simulation._sensor import Sensor
from calibore.simulation._truth import true_quantities, true_ring
from calibore.simulation._wall import PipeWall
from calibore.units import parse_quantity

TRUTH = "truth.npz"
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Station:
    """Stop `number` of the carriage, photographed `takes` times; `line` where the light differs from the survey's."""

    number: int
    takes: int = 1
    line: LineLight | None = None

    def __post_init__(self) -> None:
        if self.number < 0 or self.takes < 1:
            raise InputError(f"A station needs a number >= 0 and a take, got {self.number} and {self.takes} takes.")


@dataclass(frozen=True, eq=False)
class Survey:
    """`rig` (as it truly is) is driven along `wall` and stops at `origin` + number x `step` [m]; `pose` is
    pipe_from_rig, to which the axial position is added. `stated`: the rig as its file describes it, None for exactly.
    """

    name: str
    rig: Rig
    wall: PipeWall
    stations: tuple[Station, ...]
    origin: float
    step: float
    pose: Pose
    line: LineLight = field(default_factory=LineLight)
    sensor: Sensor = field(default_factory=Sensor)
    stated: Rig | None = None
    prefix: str = "pipe"

    def __post_init__(self) -> None:
        numbers = [station.number for station in self.stations]
        if not numbers or len(set(numbers)) < len(numbers):
            raise InputError(f"A survey needs stations with different numbers, got {numbers}.")
        if len(self.rig.lasers) != 1:
            raise InputError(f"A survey is simulated with one laser, got {len(self.rig.lasers)}.")

    @property
    def pattern(self) -> str:
        return self.prefix + " {station:03d} {take}.png"

    def pose_at(self, station: int) -> Pose:
        """pipe_from_rig at this station."""
        axial = np.array([0.0, 0.0, self.origin + station * self.step])
        return Pose(self.pose.rotation, self.pose.translation + axial)

    def line_at(self, station: Station) -> tuple[LineLight, LitLine]:
        """The light at this station, and the line it draws."""
        line, pose = station.line or self.line, self.pose_at(station.number)
        return line, lit_line(self.rig, self.wall, pipe_from_rig=pose, line=line, psf_sigma=self.sensor.psf_sigma)


def simulate_scan(folder: Path | str, survey: Survey, *, seed: int, progress: Progress | None = None) -> Path:
    """Write the scan folder `folder` (formats.md, section 2) with truth.npz beside its images; returns the folder.

    The same survey and seed give the same bytes. `progress(done, total)` counts images. The folder appears when it is
    complete; an earlier one is replaced only if it holds nothing but an earlier simulation. Raises OutputError.
    """
    folder = Path(folder).absolute()
    _check_replaceable(folder)
    total, done, rows = sum(station.takes for station in survey.stations), 0, []
    with _staged(folder) as staging:
        for station in survey.stations:
            line, lit = survey.line_at(station)
            rows.append(_truth_row(survey, station, line, lit))
            for take in range(station.takes):
                image = photograph(
                    lit,
                    survey.rig,
                    line=line,
                    sensor=survey.sensor,
                    rng=np.random.default_rng([seed, station.number, take, 1]),
                    speckle_rng=np.random.default_rng([seed, station.number, 0, 0]),
                )
                write_png(staging / survey.pattern.format(station=station.number, take=take), image)
                done += 1
                if progress is not None:
                    progress(done, total)
        _write_tables(staging, survey, rows)
    return folder


def _write_tables(staging: Path, survey: Survey, rows: list[dict[str, Any]]) -> None:
    (staging / "rig.toml").write_text(rig_toml(survey.stated or survey.rig), encoding="utf-8")
    text = scan_toml(
        name=survey.name,
        nominal_radius=survey.wall.nominal_radius,
        pattern=survey.pattern,
        origin=survey.origin,
        step=survey.step,
    )
    (staging / "scan.toml").write_text(text, encoding="utf-8")
    columns = {key: np.stack([row[key] for row in rows]) for key in rows[0]}
    files = sorted(path.name for path in staging.iterdir())
    np.savez(staging / TRUTH, allow_pickle=False, files=np.array([*files, TRUTH]), **columns)


def _truth_row(survey: Survey, station: Station, line: LineLight, lit: LitLine) -> dict[str, Any]:
    """Truth of one station. `ring_rig_*` have the axes (laser, clock) and, as the other simulated scans, inches and
    radians; `pose_t` inches; what begins with `true_` is SI.
    """
    inch, pose = parse_quantity("1 in", "length"), survey.pose_at(station.number)
    ring = true_ring(lit, survey.rig, survey.wall, pipe_from_rig=pose, line=line)
    quantities = true_quantities(lit, nominal_radius=survey.wall.nominal_radius)
    return {
        "stop": np.int64(station.number),
        "ring_phi": ring.clock,
        "ring_rig_R": ring.radius[None] / inch,
        "ring_rig_H": ring.axial[None] / inch,
        "ring_rig_visible": ring.visible[None],
        "ring_rig_signal": ring.signal[None],
        "pose_R": pose.rotation,
        "pose_t": pose.translation / inch,
        "true_axial": np.float64(pose.translation[2]),
        **{f"true_{name}": np.float64(value) for name, value in quantities.items()},
    }


def _check_replaceable(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file, not a folder; choose another name for the scan.")
    if not folder.exists() or not any(folder.iterdir()):
        return
    try:
        with np.load(folder / TRUTH, allow_pickle=False) as truth:
            known = set(truth["files"].tolist())
        foreign = sorted({path.name for path in folder.iterdir()} - known)
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        foreign = ["files"]
    if foreign:
        raise OutputError(f"{folder} holds {foreign[0]} that no simulation wrote; choose an empty or new folder.")


@contextmanager
def _staged(folder: Path) -> Iterator[Path]:
    """A hidden sibling folder that becomes `folder` when all went well, and vanishes otherwise."""
    staging = folder.with_name(f".{folder.name}.partial-{os.getpid()}")
    try:
        staging.mkdir(parents=True)
        yield staging
        if folder.exists():
            shutil.rmtree(folder)
        staging.rename(folder)
    except OSError as error:
        raise OutputError(
            f"{folder} cannot be written ({error.strerror or error}); choose a folder that you may write to."
        ) from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)

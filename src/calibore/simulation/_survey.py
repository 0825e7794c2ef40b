"""A whole scan with its truth: what is driven through which pipe, and the folder that comes of it."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from calibore.crews import Workers, in_order
from calibore.errors import InputError
from calibore.folders import whole_folder
from calibore.geometry import Pose
from calibore.rigs import Rig, SideFacing, write_rig
from calibore.simulation._encoding import Film, Still
from calibore.simulation._files import earlier_simulation, odometry_csv, scan_toml, write_truth
from calibore.simulation._lamp import Lamp, Overlay
from calibore.simulation._light import LineLight, LitLine, lit_line
from calibore.simulation._picture import photograph_all
from calibore.simulation._sensor import Sensor
from calibore.simulation._stray import seen_through
from calibore.simulation._truth_file import Columns, ring_columns, row_columns, station_truth
from calibore.simulation._wall import PipeWall
from calibore.simulation._wander import Wander
from calibore.simulation._window import CLEAR, Window

Progress = Callable[[int, int], None]
ODOMETRY = "odometry.csv"


@dataclass(frozen=True)
class Station:
    """Stop `number` of the carriage, photographed `takes` times; `line` where the light differs from the survey's;
    `angular` number of the stop of a side-facing head.
    """

    number: int
    takes: int = 1
    line: LineLight | None = None
    angular: int | None = None

    def __post_init__(self) -> None:
        if self.number < 0 or self.takes < 1:
            raise InputError(f"A station needs a number >= 0 and a take, got {self.number} and {self.takes} takes.")


@dataclass(frozen=True, eq=False)
class Survey:
    """`rig` (as it truly is) is driven along `wall` and stops at `origin` + number x `step` [m]; `pose` is
    pipe_from_rig, to which the axial position is added. Each laser shines in the takes it names. `angular` = (origin,
    step) [rad]: clocks of a side-facing head. `stated`: the rig as its file describes it, None for exactly;
    `wander`: how the carriage strays, which nobody states. The camera looks through `window`; `lamps` shine in the
    wall; `overlays` are written into the pictures, which are stored as `images` says.
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
    angular: tuple[float, float] | None = None
    wander: Wander = field(default_factory=Wander)
    window: Window = CLEAR
    lamps: tuple[Lamp, ...] = ()
    overlays: tuple[Overlay, ...] = ()
    images: Still | Film = field(default_factory=Still)

    def __post_init__(self) -> None:
        stops = [(station.number, station.angular) for station in self.stations]
        if not stops or len(set(stops)) < len(stops):
            raise InputError(f"A survey needs stations with different numbers, got {stops}.")
        turning = isinstance(self.rig.mount, SideFacing)
        if {angular is not None for _, angular in stops} | {self.angular is not None} != {turning}:
            raise InputError(
                "A side-facing head needs its clocks, and angular stops at every station; no other rig does."
            )
        numbers, angles = {number for number, _ in stops}, {angular for _, angular in stops}
        if len(stops) != len(numbers) * len(angles):
            raise InputError("A side-facing head stops at the same clocks at every station; list all of them.")
        if self.sensor.bits not in self.images.bits:
            raise InputError(
                f"JPEG and video hold 8 bits, the sensor gives {self.sensor.bits}; store its pictures as PNG."
            )
        if self.filmed and (turning or len(numbers) < 2 or any(station.takes > 1 for station in self.stations)):
            raise InputError("A video needs two stations or more with one take each, and no side-facing head.")

    @property
    def pattern(self) -> str:
        fields = "{station:03d} {take}" if self.angular is None else "{station:03d} {angular:03d} {take}"
        return f"{self.prefix} {fields}.{self.images.suffix}"

    @property
    def filmed(self) -> bool:
        """Whether the pictures are frames of a video."""
        return isinstance(self.images, Film)

    def pose_at(self, station: int, angular: int | None = None) -> Pose:
        """pipe_from_rig at this station; of the head, where it has turned to its stop `angular`."""
        axial = np.array([0.0, 0.0, self.origin + station * self.step])
        pose = Pose(self.pose.rotation, self.pose.translation + axial) @ self.wander.at(station)
        if self.angular is None or angular is None:
            return pose
        return pose @ head_pose(self.angular[0] + angular * self.angular[1])

    def line_at(self, station: Station, *, laser: int = 0) -> tuple[LineLight, LitLine]:
        """The light at this station, and the line that `laser` draws with it."""
        line, pose = station.line or self.line, self.pose_at(station.number, station.angular)
        lit = lit_line(self.rig, self.wall, pipe_from_rig=pose, line=line, psf_sigma=self.sensor.psf_sigma, laser=laser)
        return line, seen_through(lit, self.rig, self.wall, pipe_from_rig=pose, window=self.window, laser=laser)


def head_pose(clock: float) -> Pose:
    """rig_from_head of a side-facing head at `clock` [rad]: y radially outwards, z along travel."""
    return Pose.from_roll_pitch_yaw(clock + np.pi)


def simulate_scan(
    folder: Path | str,
    survey: Survey,
    *,
    seed: int,
    workers: Workers | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write the scan folder `folder` (formats.md, section 2) with truth.npz beside its images; returns the folder.

    The same survey and seed give the same bytes. `progress(done, total)` counts images. The folder appears when it is
    complete; an earlier one is replaced only if it holds nothing but an earlier simulation. `workers`: None for all
    cores. Raises OutputError.
    """
    folder = Path(folder).absolute()
    total, done, truth = sum(station.takes for station in survey.stations), 0, []
    crew = workers or os.cpu_count() or 1
    with whole_folder(folder, earlier_simulation, what="simulated scan") as staging:
        taken = in_order(survey.stations, partial(_taken, survey, seed), workers=crew)
        camera = survey.rig.camera
        with survey.images.album(staging, survey.prefix, (camera.height, camera.width)) as add:
            for station, (columns, images) in zip(survey.stations, taken, strict=True):
                truth.append(columns)
                for take, image in enumerate(images):
                    add(survey.pattern.format(**_names(station), take=take), image)
                    done += 1
                    if progress is not None:
                        progress(done, total)
        _write_tables(staging, survey, truth)
    return folder


def _taken(survey: Survey, seed: int, station: Station) -> tuple[Columns, list[Any]]:
    """The truth of a station, and its pictures as the album takes them."""
    light = station.line or survey.line
    lines = [survey.line_at(station, laser=number)[1] for number in range(len(survey.rig.lasers))]
    pose = survey.pose_at(station.number, station.angular)
    truth = station_truth(survey.rig, survey.wall, lines, pipe_from_rig=pose, line=light)
    pictures = (_photograph(survey, station, take, light, lines, seed) for take in range(station.takes))
    return truth, [survey.images.prepared(picture) for picture in pictures]


def _photograph(survey: Survey, station: Station, take: int, light: LineLight, lines: list[LitLine], seed: int) -> Any:
    lit = {number: line for number, line in enumerate(lines) if survey.rig.lasers[number].is_lit(take)}
    stop = (station.number,) if station.angular is None else (station.number, station.angular)
    radius, blur = survey.wall.nominal_radius, survey.sensor.psf_sigma
    picture = photograph_all(
        lit,
        survey.rig,
        line=light,
        sensor=survey.sensor,
        rng=np.random.default_rng([seed, *stop, take, 1]),
        speckle_rng=np.random.default_rng([seed, *stop, 0, 0]),
        window=survey.window,
        lamps=[lamp.shine(survey.rig, radius, psf_sigma=blur) for lamp in survey.lamps],
    )
    for overlay in survey.overlays:
        overlay.write_on(picture, station=station.number, axial=survey.origin + station.number * survey.step)
    return picture


def _names(station: Station) -> dict[str, int]:
    return {"station": station.number} | ({} if station.angular is None else {"angular": station.angular})


def _write_tables(staging: Path, survey: Survey, truth: list[Columns]) -> None:
    write_rig(survey.stated or survey.rig, staging / "rig.toml")
    text = scan_toml(
        name=survey.name,
        nominal_radius=survey.wall.nominal_radius,
        images=("video", f"{survey.prefix}.{survey.images.suffix}") if survey.filmed else ("pattern", survey.pattern),
        axial=(survey.origin, survey.step),
        angular=survey.angular,
        odometry=ODOMETRY if survey.filmed else None,
    )
    (staging / "scan.toml").write_text(text, encoding="utf-8")
    numbers = list(dict.fromkeys(station.number for station in survey.stations))
    poses = [survey.pose_at(number) for number in numbers]
    if isinstance(survey.images, Film):
        axial = [survey.origin + number * survey.step for number in numbers]
        (staging / ODOMETRY).write_text(odometry_csv(axial, rate=survey.images.rate), encoding="utf-8")
    if survey.angular is None:
        columns = ring_columns(truth, list(range(len(numbers))) if survey.filmed else numbers, poses)
    else:
        angles = np.array(list(dict.fromkeys(station.angular for station in survey.stations)))
        clock = survey.angular[0] + angles * survey.angular[1]
        columns = row_columns(truth, numbers, poses, angular=angles, clock=clock)
    write_truth(staging, columns)

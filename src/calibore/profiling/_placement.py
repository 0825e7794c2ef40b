"""Where the rig was at each station: from the scan's regular motion, its station table or its odometry."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.images import (
    ImageArchive,
    ImageFolder,
    ImageSource,
    StationImages,
    Video,
    read_odometry,
    read_station_table,
)
from calibore.optics import Camera
from calibore.rigs import Rig
from calibore.scans import AxialMotion, ScanSpec

FOLDER_CHANNEL = "red"
VIDEO_CHANNEL = "luma"
"""Colour is subsampled and delayed in video: it moved a ring's centre by 2.9 px where luma did not."""


@dataclass(frozen=True)
class Placement:
    """`pipe_from_rig` with its `axial` position [m] and `roll` [rad]; `time` [s] or NaN."""

    axial: float
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    time: float = float("nan")

    @property
    def pipe_from_rig(self) -> Pose:
        return Pose.from_roll_pitch_yaw(self.roll, self.pitch, self.yaw, translation=(0.0, 0.0, self.axial))


@dataclass(frozen=True)
class Placer:
    """Called with a station: its placement, or None where the scan does not say it. `expected`: stations of which it
    says one, where they are listed.
    """

    find: Callable[[StationImages], Placement | None]
    expected: Collection[int] = ()

    def __call__(self, station: StationImages) -> Placement | None:
        return self.find(station)


def open_source(spec: ScanSpec, rig: Rig) -> tuple[ImageSource, str, Placer]:
    """The scan's pictures, the colour channel in which lines are looked for where the rig file says none, and where
    its stations lie.
    """
    if spec.stream is not None:
        raise InputError(
            f"{spec.folder / 'scan.toml'} names a stream, which is measured while it comes; use `calibore live`."
        )
    if spec.video is not None:
        return _open_video(spec, spec.video, channel=video_channel(spec.video, rig), camera=rig.camera)
    pattern = spec.pattern or ""
    source = ImageArchive(spec.archive, pattern) if spec.archive else ImageFolder(spec.folder, pattern)
    return source, FOLDER_CHANNEL, placed_by_station(spec)


def video_channel(video: Path | str, rig: Rig) -> str:
    """The one colour channel in which a film or stream of `rig` is read."""
    if len({laser.channel for laser in rig.lasers}) > 1:
        raise InputError(
            f'Video "{video}" is read in one colour channel, but the lasers of the rig have several; '
            "give them one channel, or save the frames as images."
        )
    return rig.lasers[0].channel or VIDEO_CHANNEL


def _open_video(spec: ScanSpec, path: Path, *, channel: str, camera: Camera) -> tuple[ImageSource, str, Placer]:
    odometry = read_odometry(spec.motion) if isinstance(spec.motion, Path) else None
    source = Video(path, channel, odometry)
    if (source.width, source.height) != (camera.width, camera.height):
        raise InputError(
            f'Video "{path}" has frames of {source.width} x {source.height} px but the rig\'s camera has '
            f"{camera.width} x {camera.height} px; use the rig file of the camera that took it."
        )
    if odometry is None:
        return source, channel, placed_by_station(spec)

    def place(station: StationImages) -> Placement | None:
        time = station.time_s if station.time_s is not None else float("nan")
        axial, roll = odometry.at(time)
        return Placement(float(axial), float(roll), time=time)

    return source, channel, Placer(place)


def placed_by_station(spec: ScanSpec) -> Placer:
    """By the number of each station: in regular steps, or as the station table says."""
    motion = spec.motion
    if isinstance(motion, AxialMotion):
        return Placer(
            lambda station: Placement(
                float(motion.axial(station.station)), time=float("nan") if station.time_s is None else station.time_s
            )
        )
    table = read_station_table(motion)

    def place(station: StationImages) -> Placement | None:
        row = table.get(station.station)
        if row is None:
            return None
        time = float("nan") if row.time is None else row.time
        return Placement(row.axial, row.roll, row.pitch, row.yaw, time)

    return Placer(place, table.keys())

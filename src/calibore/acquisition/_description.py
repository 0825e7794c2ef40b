"""What is to be measured live, from what a user gives: a source, and scan.toml, or a rig file and a radius."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from calibore.acquisition._book import Book
from calibore.acquisition._folder import GrowingFolder
from calibore.acquisition._job import WAITING, LiveJob
from calibore.acquisition._place import LiveOdometry, placed_by_speed, placed_in_folder
from calibore.acquisition._source import LiveSource
from calibore.acquisition._stream import FIRST_ANSWER, LiveStream
from calibore.errors import InputError, UsageError
from calibore.profiling import FOLDER_CHANNEL, Placer, forward_job, forward_rig, placed_by_station, video_channel
from calibore.scans import AxialMotion, ScanSpec, read_scan, without_password

STANDING = AxialMotion(0.0, 0.0)


@dataclass(frozen=True)
class Wanted:
    """What the command line says. `step` [m], `speed` [m/s] or `odometry` say where a stream's pictures are taken; they
    come before what scan.toml says. `keep`: whether no picture may be dropped, None for what suits the source.
    """

    source: str
    scan: Path | None = None
    rig: Path | None = None
    nominal_radius: float | None = None
    step: float | None = None
    speed: float | None = None
    odometry: Path | None = None
    estimator: str = "zero-crossing"
    workers: int = 1
    waiting: int = WAITING
    keep: bool | None = None
    idle: float | None = None

    def __post_init__(self) -> None:
        moving = [name for name in ("step", "speed", "odometry") if getattr(self, name) is not None]
        if len(moving) > 1:
            raise UsageError(f"Give one of --step, --speed and --odometry, not --{' and --'.join(moving)}.")
        if (self.rig is None) != (self.nominal_radius is None):
            raise UsageError("Give --rig and --radius together: what took the pictures, and of what pipe.")
        if self.scan is not None and self.rig is not None:
            raise UsageError("Give either --scan, or --rig and --radius.")

    @property
    def is_stream(self) -> bool:
        """Whether the source is an address or a device."""
        return "://" in self.source or self.source.isdigit() or self.source.startswith("/dev/")


def described(wanted: Wanted) -> tuple[LiveJob, Callable[[Book], LiveSource]]:
    """The job, and its source once it is known what was measured before; raises InputError naming what is wrong."""
    spec = _spec(wanted)
    return _stream(wanted, spec) if spec.stream is not None else _folder(wanted, spec)


def _spec(wanted: Wanted) -> ScanSpec:
    if wanted.is_stream:
        return read_scan(wanted.scan, stream=wanted.source) if wanted.scan else _minimal(wanted)
    if wanted.rig is not None:
        raise UsageError("A folder of pictures is described by its scan.toml; --rig and --radius are for streams.")
    folder = Path(wanted.source)
    if wanted.scan is None:
        return read_scan(folder)
    if not folder.is_dir():
        raise InputError(f'Image folder "{folder}" does not exist; make it before the pictures come.')
    return replace(read_scan(wanted.scan), folder=folder.resolve())


def _minimal(wanted: Wanted) -> ScanSpec:
    """A stream without a scan.toml."""
    if wanted.rig is None or wanted.nominal_radius is None:
        raise UsageError(
            f"{without_password(wanted.source)} needs --scan scan.toml, or --rig rig.toml with --radius of the pipe."
        )
    name = without_password(wanted.source)
    return ScanSpec(
        folder=Path.cwd(),
        name=name,
        rig_path=wanted.rig,
        nominal_radius=wanted.nominal_radius,
        motion=STANDING,
        identity=hashlib.sha256(f"live {name}".encode()).hexdigest()[:16],
        stream=wanted.source,
    )


def _stream(wanted: Wanted, spec: ScanSpec) -> tuple[LiveJob, Callable[[Book], LiveSource]]:
    rig = forward_rig(spec, estimator=wanted.estimator)
    address = spec.stream or wanted.source
    channel = video_channel(without_password(address), rig)
    job = forward_job(spec, rig, channel=channel, estimator=wanted.estimator)
    stream = LiveStream(
        address,
        (rig.camera.width, rig.camera.height),
        channel,
        patience=max(FIRST_ANSWER, wanted.idle or 0.0),
        idle=wanted.idle,
        keeps=bool(wanted.keep),
    )
    place, by_step = _motion(wanted, spec, stream)
    standing = not by_step and wanted.speed is None and wanted.odometry is None and spec.motion == STANDING
    more = {"by_step": by_step, "standing": standing}
    live = LiveJob(spec, job, place, wanted.workers, wanted.waiting, keep=bool(wanted.keep), **more)

    def after(book: Book) -> LiveSource:
        if book.last_station is not None:
            stream.go_on_after(book.last_station, book.began)
        return stream

    return live, after


def _motion(wanted: Wanted, spec: ScanSpec, stream: LiveStream) -> tuple[Placer, bool]:
    """Where a stream's pictures are taken, and whether that goes by their number."""
    motion = wanted.odometry or spec.motion
    if wanted.speed is not None or (wanted.step is None and motion == STANDING):
        return placed_by_speed(wanted.speed or 0.0), False
    if wanted.step is None and isinstance(motion, Path):
        return Placer(LiveOdometry(motion, lambda: stream.began)), False
    by_number = spec.motion if wanted.step is None else AxialMotion(0.0, wanted.step)
    return placed_by_station(replace(spec, motion=by_number)), True


def _folder(wanted: Wanted, spec: ScanSpec) -> tuple[LiveJob, Callable[[Book], LiveSource]]:
    if spec.pattern is None or spec.archive is not None:
        raise InputError(
            f"{spec.folder} is no folder of pictures that may be growing, and no stream; use `calibore profile`."
        )
    if any(one is not None for one in (wanted.step, wanted.speed, wanted.odometry)):
        raise UsageError("Where the pictures of a folder are taken is said by [motion] in its scan.toml.")
    if wanted.keep is False:
        raise UsageError("The pictures of a folder wait on the disk: none is dropped; leave out --drop oldest.")
    rig = forward_rig(spec, estimator=wanted.estimator)
    job = forward_job(spec, rig, channel=FOLDER_CHANNEL, estimator=wanted.estimator)
    pattern = spec.pattern
    live = LiveJob(spec, job, placed_in_folder(spec), wanted.workers, wanted.waiting, keep=True)
    return live, lambda book: GrowingFolder(spec.folder, pattern, wanted.idle, after=book.last_station)

"""A video as a row of stations: frames in order, the luma plane as it was coded."""

from bisect import bisect_left, bisect_right, insort
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from calibore.errors import ImageError, InputError
from calibore.images._source import Pixels, Refusal, StationImages
from calibore.images._tables import Odometry
from calibore.images._video_pixels import frame_pixels

CHANNELS = ("luma", "red", "green", "blue")

FAILING_ON_DAMAGE = ("h264", "mjpeg")
"""Decoders that must be told to fail on damage instead of patching it up unmarked; others (MPEG-2) mark such frames."""

CORRUPT = "the video data are corrupt there, or in a frame that it builds on"
SHORT_FILE = "the file holds fewer frames than it announces (cut short, or damaged and later frames numbered too low)"
SHORT_ODOMETRY = "odometry shorter than the video"


@dataclass(frozen=True)
class Video:
    """The frames of a video file, one station each: station = frame number from 0, take 0, time since its start.

    `channel` "luma" gives the luma plane, shape (h, w), without any colour conversion and in the range it was coded
    (limited range stays limited); "red", "green" and "blue" give colour, shape (h, w, 3). 9 to 16 bit video comes as
    uint16 scaled to 16 bits. Frames outside the times of `odometry` and corrupt frames are left out and counted in
    `refusals`. Decoding happens in `stations`, in the thread that iterates, one frame at a time.

    Raises InputError for a file that is not a readable video, or (at the end of `stations`) if it has no usable frame.
    """

    path: Path
    channel: str = "luma"
    odometry: Odometry | None = None
    width: int = field(init=False)
    height: int = field(init=False)
    expected_stations: int | None = field(init=False)
    _refused: "_Refusals" = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.channel not in CHANNELS:
            raise InputError(f'Video channel "{self.channel}" is not known; allowed: {", ".join(CHANNELS)}.')
        container, stream = _opened(self.path)
        with container:
            if not stream.width or not stream.height:
                raise InputError(
                    f'Video "{self.path}" does not say how large its frames are; convert it to H.264 in MP4.'
                )
            found = (stream.width, stream.height, stream.frames or None)
        for name, value in zip(("width", "height", "expected_stations"), found, strict=True):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_refused", _Refusals())

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        return self._refused.all()

    def stations(self) -> Iterator[StationImages]:
        """The frames in order of presentation."""
        self._refused.clear()
        usable = False
        container, stream = _opened(self.path)
        with container:
            constant_rate = container.format.name == "avi"  # AVI stores no presentation times
            for number, time, frame in _Numbered(stream, self._refused, constant_rate=constant_rate).frames(container):
                if self.odometry is not None and not self.odometry.covers(time):
                    covered = f"the table covers {self.odometry.time[0]:g} s to {self.odometry.time[-1]:g} s"
                    self._refused.add(f"{SHORT_ODOMETRY} ({covered})", number)
                    continue
                try:
                    pixels = frame_pixels(frame, self.channel)
                except ImageError as error:
                    self._refused.add(str(error), number)
                    continue
                usable = True
                yield _station(number, time, pixels)
        if not usable:
            why = "; ".join(map(str, self.refusals)) or "it holds none"
            raise InputError(
                f'Video "{self.path}" has no usable frame ({why.rstrip(".")}); '
                "give another recording or a longer table."
            )


class _Refusals:
    """Why frames were left out: how many for each reason, and the first."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._first: dict[str, int] = {}

    def clear(self) -> None:
        self._counts.clear()
        self._first.clear()

    def add(self, reason: str, station: int, count: int = 1) -> None:
        self._counts[reason] += count
        self._first.setdefault(reason, station)

    def all(self) -> tuple[Refusal, ...]:
        return tuple(Refusal(reason, count, self._first[reason]) for reason, count in self._counts.items())


def _opened(path: Path) -> tuple[Any, Any]:
    """Container and video stream."""
    import av  # 0.1 s
    from av.error import FFmpegError

    try:
        if not path.is_file():  # PyAV would take the text for an address
            raise InputError(f'Video "{path}" does not exist; give the path of an existing file.')
        container = av.open(str(path), options={"protocol_whitelist": "file"}, metadata_errors="replace")
    except (FFmpegError, OSError) as error:
        raise InputError(f'Video "{path}" cannot be read ({error.strerror}); give a readable video file.') from error
    stream = next(iter(container.streams.video), None)
    if stream is None:
        container.close()
        raise InputError(f'"{path}" has no video stream; give a video file.')
    if stream.codec_context is None:
        container.close()
        raise InputError(f'Video "{path}" has an unknown or damaged coding; convert it to H.264 in MP4.')
    if stream.codec_context.name in FAILING_ON_DAMAGE:
        stream.codec_context.options = {"err_detect": "explode"}
    return container, stream


class _Numbered:
    """Decoded frames with their number and time [s]; a frame that is lost keeps its number.

    A packet whose time no frame shows was lost, even where the decoder did not complain. Frames between a loss and the
    next key frame build on what was lost: they would look right and be wrong.
    """

    def __init__(self, stream: Any, refused: _Refusals, *, constant_rate: bool) -> None:
        self._stream = stream
        self._refused = refused
        self._constant_rate = constant_rate
        self._next = 0
        self._awaited: list[int] = []  # presentation times of packets whose frames are still to come, sorted
        self._failed: set[int] = set()
        self._damaged_until: int | None = None  # time of the latest damage that no later key frame has ended

    def frames(self, container: Any) -> Iterator[tuple[int, float, Any]]:
        packets = 0
        for packet in _packets(container, self._stream):
            packets += packet.size > 0
            for frame in self._decoded(packet):
                self._count_lost(frame)
                number = self._next
                self._next += 1
                if self._is_sound(frame):
                    yield number, self._time(frame, number), frame
                else:
                    self._refused.add(CORRUPT, number)
        self._lose(self._awaited)
        if packets < self._stream.frames:
            self._refused.add(SHORT_FILE, packets, self._stream.frames - packets)

    def _decoded(self, packet: Any) -> list[Any]:
        from av.error import FFmpegError

        if not packet.size and packet.dts is not None:  # "as before": to decode it would end the decoding
            self._next += 1
            return []
        time = None if self._constant_rate else packet.pts
        if packet.size and not packet.is_discard and time is not None:
            insort(self._awaited, time)
        try:
            return packet.decode()
        except FFmpegError:
            self._damage(packet.pts or 0)
            if time is None:
                self._lose([packet.pts or 0])
            else:
                self._failed.add(time)
            return []

    def _count_lost(self, frame: Any) -> None:
        """Whatever was to come before this frame will not come any more."""
        if frame.pts is None:
            self._awaited.clear()
            return
        shown = bisect_left(self._awaited, frame.pts)
        lost = self._awaited[:shown]
        if frame.interlaced_frame:  # two fields, two packets, one frame
            lost = [time for time in lost if time in self._failed]
        self._lose(lost)
        self._failed.difference_update(lost)
        del self._awaited[: bisect_right(self._awaited, frame.pts)]

    def _lose(self, times: list[int]) -> None:
        if times:
            self._refused.add(CORRUPT, self._next, len(times))
            self._next += len(times)
            self._damage(times[-1])

    def _damage(self, time: int) -> None:
        self._damaged_until = max(time, self._damaged_until or time)

    def _is_sound(self, frame: Any) -> bool:
        if frame.is_corrupt:
            self._damage(frame.pts or 0)
        elif self._damaged_until is not None and frame.key_frame and (frame.pts or 0) > self._damaged_until:
            self._damaged_until = None
        return self._damaged_until is None

    def _time(self, frame: Any, number: int) -> float:
        if frame.pts is None or self._constant_rate:
            return number / float(self._stream.average_rate or 1)
        return float((frame.pts - (self._stream.start_time or 0)) * frame.time_base)


def _packets(container: Any, stream: Any) -> Iterator[Any]:
    """Packets up to the end of what can be read."""
    from av.error import FFmpegError

    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets)
        except (StopIteration, FFmpegError):
            return
        yield packet


def _station(number: int, time: float, pixels: Pixels) -> StationImages:
    def read(take: int) -> Pixels:
        if take != 0:
            raise ImageError(f"Frame {number} has no take {take}; a video has take 0 only.")
        return pixels

    return StationImages(number, (0,), read, time_s=time, names=(f"frame {number}",))

"""A stream while it comes: camera, network, device; frames in order, each with its number and time."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Any

from calibore.errors import InputError
from calibore.images._pace import Pace
from calibore.images._source import Pixels, Refusal
from calibore.images._video import FAILING_ON_DAMAGE, _Numbered, _Refusals
from calibore.images._video_pixels import frame_pixels

OPENING = 10.0
"""Seconds that a source may take to answer."""
HOPELESS = ("FileNotFoundError", "PermissionError", "HTTPUnauthorizedError", "HTTPForbiddenError", "HTTPNotFoundError")
"""What waiting does not cure."""
LIVE = {"analyzeduration": "500000", "fpsprobesize": "0"}
"""Microseconds and frames that are looked at before the first is handed out; FFmpeg's own are seconds."""
FRAMES_PER_SECOND = 25.0
"""Where a stream does not say."""
FASTEST = 1000.0
"""Frames per second; what claims more does not know."""
TCP = {"rtsp_transport": "tcp", "probesize": "32", "fpsprobesize": "0"}
"""RTSP says what it will send before it does: to look at one packet is enough."""
UDP = TCP | {"rtsp_transport": "udp", "buffer_size": "4000000"}
"""The buffer takes a burst: the packets of a large key frame come at once."""


class StreamError(InputError):
    """A source that does not answer, or has ceased to; `hopeless` where it will not answer later either."""

    def __init__(self, reason: str, *, hopeless: bool = False) -> None:
        super().__init__(reason)
        self.hopeless = hopeless


@dataclass(frozen=True, eq=False)
class StreamFrame:
    """Frame `number` of a connection, from 0 for the first one that can be shown, `time` [s] after it."""

    number: int
    time: float
    _frame: Any = field(repr=False)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) [px]"""
        return self._frame.width, self._frame.height

    def pixels(self, channel: str) -> Pixels:
        """As `Video` gives them."""
        return frame_pixels(self._frame, channel)


class StreamFrames:
    """Iterates over the frames of one connection until it ends; `refusals`: what was lost since the first frame.

    Frames that come before the first key frame cannot be shown, and are nobody's loss.
    """

    def __init__(self, container: Any, stream: Any, *, keep_up: bool) -> None:
        self._demuxer = _Demuxer(container, Pace() if keep_up else None)
        self._skipped_before = 0
        self._lost = _Refusals()
        self._frames = _Numbered(stream, self._lost, constant_rate=False).frames(self._demuxer)
        rate = float(stream.average_rate or 0.0)
        self._rate = rate if 1.0 <= rate <= FASTEST else FRAMES_PER_SECOND
        self._first: int | None = None
        self._start: float | None = None

    def __iter__(self) -> Iterator[StreamFrame]:
        for number, time, frame in self._frames:
            if self._first is None:
                self._first, self._skipped_before = number, self._demuxer.skipped
                self._lost.clear()
            place = number - self._first + self.skipped
            yield StreamFrame(place, self._since(place, time, frame), frame)

    def _since(self, number: int, time: float, frame: Any) -> float:
        """Seconds since the first frame; that of RTSP comes without a time, a regular step before the second."""
        if frame.pts is None:
            return number / self._rate
        if self._start is None:
            self._start = time - number / self._rate
        return time - self._start

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """Numbered as the frames."""
        first = self._first or 0
        return tuple(Refusal(one.reason, one.count, one.station - first) for one in self._lost.all())

    @property
    def skipped(self) -> int:
        """Frames that were not decoded because this program could not keep up."""
        return self._demuxer.skipped - self._skipped_before

    @property
    def why_it_ended(self) -> str:
        """In words that follow "the source is gone"."""
        return self._demuxer.why


class _Demuxer:
    """The container's packets, less those that `pace` skips, and why there are no more."""

    def __init__(self, container: Any, pace: Pace | None) -> None:
        self._container, self._pace = container, pace
        self.skipped = 0
        self.why = "it sends nothing more"

    def demux(self, stream: Any) -> Iterator[Any]:
        from av.error import FFmpegError

        try:
            for packet in self._container.demux(stream):
                if self._skips(packet):
                    self.skipped += 1
                else:
                    yield packet
        except FFmpegError as error:
            self.why = _why(error)

    def _skips(self, packet: Any) -> bool:
        if self._pace is None or packet.pts is None or not packet.size:
            return False
        return self._pace.skips(float(packet.pts * packet.time_base), monotonic(), key=packet.is_keyframe)


@contextmanager
def opened_stream(address: str, *, silence: float, keep_up: bool = True) -> Iterator[StreamFrames]:
    """The frames of `address`: a network address (rtsp, http, tcp, udp), a device (`/dev/video0`) or its number.

    A source that is silent for `silence` [s] has ended. With `keep_up` frames are skipped where they come faster than
    they can be decoded, so that they are fresh. RTSP comes over TCP where the server can, else over UDP. Raises
    StreamError where nothing answers, or what answers is no video.
    """
    container = _connected(address, silence)
    try:
        stream = next(iter(container.streams.video), None)
        if stream is None or stream.codec_context is None:
            raise StreamError("what it sends is no video that can be decoded", hopeless=True)
        if stream.codec_context.name in FAILING_ON_DAMAGE:
            stream.codec_context.options = {"err_detect": "explode"}
        yield StreamFrames(container, stream, keep_up=keep_up)
    finally:
        with suppress(Exception):
            container.close()


def _connected(address: str, silence: float) -> Any:
    from av.error import FFmpegError

    if "://" not in address:
        return _device(address, silence)
    if not address.startswith(("rtsp://", "rtsps://")):
        return _container(address, silence, LIVE)
    try:
        return _container(address, silence, TCP)
    except StreamError as error:
        cause = error.__cause__
        if isinstance(cause, FFmpegError) and "rotocol not supported" in str(cause.strerror):
            return _container(address, silence, UDP)
        raise


def _device(name: str, silence: float) -> Any:
    import sys

    path = f"/dev/video{name}" if name.isdigit() else name
    if sys.platform == "darwin":
        return _container(name, silence, {"framerate": "30"}, format="avfoundation")
    if sys.platform == "win32":
        return _container(f"video={name}", silence, {}, format="dshow")
    if not Path(path).exists():
        raise StreamError("there is no such device; plug the camera in, or see which there are: ls /dev/video*")
    return _container(path, silence, {}, format="v4l2")


def _container(address: str, silence: float, options: dict[str, str], *, format: str | None = None) -> Any:
    import av
    from av.error import FFmpegError

    try:
        return av.open(address, format=format, options=options, timeout=(OPENING, silence))
    except (FFmpegError, OSError) as error:
        raise StreamError(_why(error), hopeless=type(error).__name__ in HOPELESS) from error


def _why(error: Exception) -> str:
    """What FFmpeg says, without the address: it may hold a password."""
    if type(error).__name__ == "ExitError":
        return "it is silent"
    said = getattr(error, "strerror", None) or type(error).__name__
    return said[:1].lower() + said[1:]

"""A camera or network stream that may stop, stutter, change its size, or go away and come back."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from threading import Event

from calibore.acquisition._backlog import DROPPED, Arrival, Backlog, LeftOut, now
from calibore.errors import ImageError, InputError
from calibore.images import Pixels, StationImages, StreamError, StreamFrame, StreamFrames, opened_stream
from calibore.scans import without_password

SILENCE = 5.0
"""Seconds without a picture after which a stream counts as gone."""
FIRST_PAUSE, LONGEST_PAUSE = 0.5, 30.0
"""Seconds before the first attempt to connect again; each further pause is twice as long, up to the longest."""
FIRST_ANSWER = 10.0
"""Seconds within which a source must have sent its first picture, where nobody asks for more."""
TICK = 1e-6
"""Seconds: pictures never have the same time."""
LEAST = 1e-3
"""Seconds between the last picture before an absence and the first after it, whatever the clocks say."""
AGAIN = "check its power, its network and the address"


@dataclass
class LiveStream:
    """The pictures of `address` (as `opened_stream` takes it) of `size` (width, height) [px], read in `channel`.

    Stations are numbered from 0 without gaps while the stream is there, pictures left out counted; `time_s` runs on
    while it is away. `patience` [s]: how long the first picture is waited for; after that InputError says why none
    came. Once it was there, a stream that goes away is waited for, for ever or for `idle` [s].
    """

    address: str
    size: tuple[int, int]
    channel: str
    patience: float = FIRST_ANSWER
    idle: float | None = None
    silence: float = SILENCE
    keeps: bool = False
    waiting: int = field(default=0, init=False)
    connected: bool = field(default=False, init=False)
    absences: int = field(default=0, init=False)
    began: float | None = field(default=None, init=False)
    """Unix time [s] at which `time_s` is 0."""

    def __post_init__(self) -> None:
        self._next = 0
        self._last_time = -1.0
        self._seen_size = self.size
        self._came = False

    @property
    def name(self) -> str:
        return without_password(self.address)

    def go_on_after(self, station: int, began: float | None) -> None:
        """Number the next picture after `station`, its time since the Unix time `began` [s]."""
        self._next, self.began = station + 1, began

    def arrivals(self, backlog: Backlog, stop: Event) -> Iterator[Arrival]:
        """The pictures as they come, until `stop`; raises InputError where not one has come in time."""
        pause, last = FIRST_PAUSE, now()
        while not stop.is_set():
            before = self._next
            try:
                with opened_stream(self.address, silence=self.silence, keep_up=not self.keeps) as frames:
                    yield from self._of(frames, backlog, stop)
                why, hopeless = frames.why_it_ended, False
            except StreamError as error:
                why, hopeless = str(error), error.hopeless
            self.connected = False
            if stop.is_set():
                return
            if self._next > before:
                pause, last = FIRST_PAUSE, now()
                self.absences += 1
            if not self._came and (hopeless or now() - last + pause > self.patience):
                raise InputError(f"{self.name} sends no picture ({why}); {AGAIN}.")
            if self._came and self.idle is not None and now() - last >= self.idle:
                return
            backlog.say(f"{self.name} is gone ({why}); trying again in {pause:g} s. If it stays away, {AGAIN}.")
            stop.wait(pause if self.idle is None or not self._came else min(pause, self.idle))
            pause = min(2 * pause, LONGEST_PAUSE)

    def _of(self, frames: StreamFrames, backlog: Backlog, stop: Event) -> Iterator[Arrival]:
        """The pictures of one connection."""
        base, lost, skipped, start = self._next, 0, 0, 0.0
        for frame in frames:
            if not self.connected:
                start, self.connected = self._connected(backlog), True
            at, seconds = now(), max(start + frame.time, self._last_time + TICK)
            lost = self._lost(frames, lost, seconds, backlog)
            if (behind := frames.skipped - skipped) > 0:
                first = base + frame.number - behind
                backlog.say(LeftOut(first, self._last_time, DROPPED, refused=False, count=behind))
                skipped += behind
            self._next, self._last_time = base + frame.number + 1, seconds
            if self._fits(frame, base + frame.number, seconds, backlog):
                yield Arrival(_station(base + frame.number, seconds, frame, self.channel), at)
            if stop.is_set():
                return

    def _connected(self, backlog: Backlog) -> float:
        """The time of the first picture of a connection."""
        if self.began is None:
            self.began = time.time()
            self._came = True
            return 0.0
        if self._came:
            backlog.say(f"{self.name} is back.")
        self._came = True
        return max(time.time() - self.began, self._last_time + LEAST)

    def _lost(self, frames: StreamFrames, before: int, seconds: float, backlog: Backlog) -> int:
        """Says what the connection has lost since `before` pictures were lost."""
        refusals = frames.refusals
        count = sum(one.count for one in refusals)
        if count > before:
            backlog.say(LeftOut(self._next, seconds, refusals[-1].reason, refused=True, count=count - before))
        return count

    def _fits(self, frame: StreamFrame, number: int, seconds: float, backlog: Backlog) -> bool:
        """Whether the picture has the size of the rig's camera; says so once whenever that changes."""
        fits, why = frame.size == self.size, f"{_px(frame.size)} but the rig's camera has {_px(self.size)}"
        if frame.size != self._seen_size:
            self._seen_size = frame.size
            backlog.say(
                f"{self.name} sends pictures of {_px(self.size)} again."
                if fits
                else f"{self.name} now sends pictures of {why}; they are left out until it does again."
            )
        if not fits:
            backlog.say(LeftOut(number, seconds, f"it is {why}; use the rig file of that camera", refused=True))
        return fits


def _px(size: tuple[int, int]) -> str:
    return f"{size[0]} x {size[1]} px"


def _station(number: int, seconds: float, frame: StreamFrame, channel: str) -> StationImages:
    def read(take: int) -> Pixels:
        if take != 0:
            raise ImageError(f"Picture {number} of a stream has no take {take}; it has take 0 only.")
        return frame.pixels(channel)

    return StationImages(number, (0,), read, time_s=seconds, names=(f"picture {number}",))

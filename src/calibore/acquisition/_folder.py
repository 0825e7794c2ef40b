"""A folder that somebody is still filling: pictures in order of station, none before it is complete."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from threading import Event

from calibore.acquisition._backlog import Arrival, Backlog, LeftOut, now
from calibore.errors import ImageError, InputError
from calibore.images import NamePattern, Pixels, StationImages, names_in, read_image

POLL = 0.05
"""Seconds between two looks at the folder."""
SHARE = 5.0
"""Times as long as a look takes, in a folder of very many files, pass before the next."""
SETTLED = 0.15
"""Seconds that a file must not have changed before it is opened."""
GRACE = 2.0
"""Seconds that a file which cannot be decoded must not have changed before it counts as broken."""
LATE = 1.0
"""Seconds that a station which leaves a gap, or has fewer takes than others, is waited for what lacks."""
FOLLOWERS = 2
"""Later stations that, once begun, tell that no further take of this one will come."""
TOO_LATE = "it came after pictures of later stations; rings are written in their order, so `calibore profile` takes it"


@dataclass
class _File:
    path: Path
    seen: tuple[int, int]
    since: float
    """When it was last seen to change."""


@dataclass
class GrowingFolder:
    """The images in `folder` whose names match `pattern`, as they come, after station `after`.

    A picture is handed out when its file has not changed for a moment, in order of station. While stations before it or
    further takes of it may be on their way, it waits up to `late` [s]; for takes, until two later stations have begun.
    A file that cannot be decoded is tried again until it has not changed for `grace` [s]. Ends after `idle` [s] without
    a new picture.
    """

    folder: Path
    pattern: str
    idle: float | None = None
    after: int | None = None
    late: float = LATE
    grace: float = GRACE
    keeps: bool = True
    connected: bool = field(default=True, init=False)

    def __post_init__(self) -> None:
        self._matcher = NamePattern(self.pattern)
        self._names: set[str] = set()
        self._stations: dict[int, dict[int, _File]] = {}
        self._last, self._step = self.after, 0
        self._takes = 2 if "{take" in self.pattern else 1
        if not self.folder.is_dir():
            raise InputError(f'Image folder "{self.folder}" does not exist; make it before the pictures come.')

    @property
    def name(self) -> str:
        return str(self.folder)

    @property
    def waiting(self) -> int:
        return len(self._stations)

    def arrivals(self, backlog: Backlog, stop: Event) -> Iterator[Arrival]:
        """The stations as they become complete, until `stop` or `idle`; raises InputError where the folder goes."""
        last_new, begun, next_look = now(), time.time(), 0.0
        while not stop.is_set():
            if (looked := now()) >= next_look:
                last_new = now() if self._look(backlog) else last_new
                next_look = now() + max(POLL, SHARE * (now() - looked))
            ready = self._ready()
            if ready is not None:
                yield self._handed_out(ready, begun)
                last_new = now()
            elif self.idle is not None and not self._stations and now() - last_new >= self.idle:
                return
            else:
                stop.wait(POLL)

    def _look(self, backlog: Backlog) -> bool:
        """Note what is new; whether there was anything."""
        new, moment = False, now()
        try:
            for name in names_in(self.folder, self._matcher):
                if name not in self._names:
                    self._names.add(name)
                    new |= self._note(name, moment, backlog)
        except OSError as error:
            raise InputError(f'Image folder "{self.folder}" cannot be read any more ({error.strerror}).') from error
        return new

    def _note(self, name: str, moment: float, backlog: Backlog) -> bool:
        numbers = self._matcher.match(name)
        if numbers is None:
            return False
        station = numbers["station"]
        if self._last is not None and station <= self._last:
            if self.after is None or station > self.after:
                backlog.say(LeftOut(station, float("nan"), TOO_LATE, refused=True))
            return False
        path = self.folder / name
        self._stations.setdefault(station, {})[numbers["take"]] = _File(path, _state(path), moment)
        return True

    def _ready(self) -> int | None:
        """The station to be handed out next, if it is complete."""
        if not self._stations:
            return None
        station, moment = min(self._stations), now()
        files = self._stations[station].values()
        for file in files:
            if (state := _state(file.path)) != file.seen:
                file.seen, file.since = state, moment
        quiet = moment - max(file.since for file in files)
        empty = any(file.seen[0] <= 0 for file in files) and quiet < self.grace
        if quiet < SETTLED or empty:
            return None
        gap = self._step > 0 and self._last is not None and station > self._last + self._step
        short = len(files) < self._takes and len(self._stations) <= FOLLOWERS
        return None if (gap or short) and quiet < self.late else station

    def _handed_out(self, station: int, begun: float) -> Arrival:
        files = dict(sorted(self._stations.pop(station).items()))
        if self._last is not None:
            self._step = min(self._step or station - self._last, station - self._last)
        self._last, self._takes = station, max(self._takes, len(files))
        names = tuple(file.path.relative_to(self.folder).as_posix() for file in files.values())
        read = partial(_read, {take: file.path for take, file in files.items()}, grace=self.grace)
        written = max(begun, *(file.seen[1] / 1e9 for file in files.values()))
        return Arrival(StationImages(station, tuple(files), read, names=names), now() - max(time.time() - written, 0.0))


def _state(path: Path) -> tuple[int, int]:
    """Size and time of change; what has gone is empty."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns


def _read(paths: dict[int, Path], take: int, *, grace: float) -> Pixels:
    """The pixels, once the file can be decoded; one that does not change for a while and cannot is broken."""
    path = paths[take]
    state = _state(path)
    since = now() - max(time.time() - state[1] / 1e9, 0.0)
    while True:
        try:
            return read_image(path)
        except ImageError:
            if now() - since > grace:
                raise
        time.sleep(POLL)
        if (current := _state(path)) != state:
            state, since = current, now()

"""Pictures that wait to be measured: a ring of fixed size between the thread that fetches and the one that measures."""

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from threading import Condition, Event

from calibore.images import StationImages

DROPPED = "it came faster than pictures could be measured"
BEAT = 0.2
"""Seconds after which whoever waits looks round."""


@dataclass(frozen=True)
class Arrival:
    """The pictures of a station; `at`: when they were complete here, on the clock of `time.monotonic`."""

    images: StationImages
    at: float


@dataclass(frozen=True)
class LeftOut:
    """`count` pictures that were not measured, the first numbered `station` and taken `time_s` after the first of all;
    `refused` where they could not be, else they were dropped.
    """

    station: int
    time_s: float
    why: str
    refused: bool
    count: int = 1


class Backlog:
    """At most `size` arrivals. Where one more comes, the oldest is dropped, or with `keep` the bringer waits.

    `changed` is notified whenever something came, went or was said. Sentences and pictures left out are handed from one
    thread to the other in their order by `events`.
    """

    def __init__(self, size: int, *, keep: bool) -> None:
        self.size, self._keep = size, keep
        self.changed = Condition()
        self.arrived = 0
        self.closed = False
        self.error: BaseException | None = None
        self._waiting: deque[Arrival] = deque()
        self._events: deque[str | LeftOut] = deque()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, arrival: Arrival, stop: Event) -> bool:
        """Whether `arrival` was taken; False where `stop` was set while its bringer waited."""
        with self.changed:
            while self._keep and len(self._waiting) >= self.size:
                if stop.is_set():
                    return False
                self.changed.wait(BEAT)
            self.arrived += 1
            if len(self._waiting) >= self.size:
                oldest = self._waiting.popleft().images
                self._events.append(LeftOut(oldest.station, _time(oldest), DROPPED, refused=False))
            self._waiting.append(arrival)
            self.changed.notify_all()
        return True

    def take(self) -> Arrival | None:
        """The oldest that waits, if any."""
        with self.changed:
            arrival = self._waiting.popleft() if self._waiting else None
            self.changed.notify_all()
        return arrival

    def say(self, event: str | LeftOut) -> None:
        """A sentence for people, or a picture that its bringer has left out."""
        with self.changed:
            self._events.append(event)
            self.changed.notify_all()

    def events(self) -> Iterator[str | LeftOut]:
        """What was said since the last call."""
        while self._events:
            yield self._events.popleft()

    def close(self, error: BaseException | None = None) -> None:
        """Nothing more will come; `error` where that was nobody's wish."""
        with self.changed:
            self.closed, self.error = True, error
            self.changed.notify_all()


def _time(images: StationImages) -> float:
    return float("nan") if images.time_s is None else images.time_s


def now() -> float:
    """The clock of `Arrival.at` [s]."""
    return time.monotonic()

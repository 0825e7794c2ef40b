"""What every live source offers."""

from collections.abc import Iterator
from threading import Event
from typing import Protocol

from calibore.acquisition._backlog import Arrival, Backlog


class LiveSource(Protocol):
    """`arrivals` runs in a thread of its own until the source ends or `stop` is set."""

    @property
    def name(self) -> str:
        """As people know it, without a password."""
        ...

    @property
    def keeps(self) -> bool:
        """Whether pictures stay where they are until they are fetched, so that none is ever dropped."""
        ...

    @property
    def waiting(self) -> int:
        """Pictures that are there but were not fetched yet."""
        ...

    @property
    def connected(self) -> bool: ...

    def arrivals(self, backlog: Backlog, stop: Event) -> Iterator[Arrival]:
        """The pictures as they come; what has to be said of them, and those left out, go to `backlog.say`."""
        ...

"""What is measured live and how, and what ends it."""

from dataclasses import dataclass, field
from threading import Event

from calibore.profiling import Job, Placer
from calibore.scans import ScanSpec

WAITING = 4
"""Pictures that may wait to be measured, where nobody says how many."""


@dataclass(frozen=True)
class Limits:
    """What ends a run besides its source: rings, seconds; `stop`, when somebody sets it."""

    count: int | None = None
    duration: float | None = None
    stop: Event = field(default_factory=Event)


@dataclass(frozen=True)
class LiveJob:
    """What is measured and how. `place` is called in the order of the pictures; `by_step`: it counts them;
    `standing`: nobody said that the rig moves.

    `size`: pictures that may wait; `keep`: none is ever dropped, else the oldest that waits is.
    """

    spec: ScanSpec
    job: Job
    place: Placer
    workers: int
    size: int = WAITING
    keep: bool = False
    by_step: bool = False
    standing: bool = False

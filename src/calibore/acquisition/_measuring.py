"""Pictures measured as they come: each result as soon as it is there, in order, with little work under way."""

import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NamedTuple

from threadpoolctl import threadpool_limits

from calibore.acquisition._backlog import BEAT, Arrival, Backlog
from calibore.profiling import (
    Job,
    Placement,
    Placer,
    StationRefusedError,
    StationResult,
    evaluate_station,
    find_lines,
)

PATIENCE = 5e-4
"""Seconds that the thread which fetches pictures waits for the one that measures; Python's own are ten times that."""


class Outcome(NamedTuple):
    """What became of an arrival: its `result`, why it has none, or None where nobody knows its place."""

    arrival: Arrival
    result: StationResult | StationRefusedError | None


class _Work(NamedTuple):
    arrival: Arrival
    placement: Placement
    lines: Future[Any]


def measured(
    backlog: Backlog, job: Job, place: Placer, *, workers: int, beat: Callable[[], None]
) -> Generator[Outcome]:
    """Everything that comes through `backlog` until it is closed; `beat` is called several times a second.

    Threads find lines, one picture more than there are `workers` at a time, so that what is measured is fresh; the rest
    is done here. Leaving the iteration early gives up what is under way.
    """
    working: deque[_Work] = deque()

    def something_to_do() -> bool:
        return bool(
            (working and working[0].lines.done()) or (len(working) <= workers and len(backlog)) or backlog.closed
        )

    pool = ThreadPoolExecutor(workers, thread_name_prefix="calibore")
    try:
        while True:
            beat()
            with backlog.changed:
                backlog.changed.wait_for(something_to_do, BEAT)
            while len(working) <= workers and (arrival := backlog.take()) is not None:
                placement = place(arrival.images)
                if placement is None:
                    yield Outcome(arrival, None)
                    break
                lines = pool.submit(find_lines, arrival.images, job)
                lines.add_done_callback(lambda _: _told(backlog))
                working.append(_Work(arrival, placement, lines))
            if working and (working[0].lines.done() or backlog.closed):
                yield _evaluated(working.popleft(), job)
            elif backlog.closed and not working and not len(backlog):
                return
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def prepared() -> Iterator[None]:
    """What takes long once is done before the first picture comes; linear algebra keeps to one thread meanwhile."""
    import_module("zarr")  # 0.7 s, which would come when the first chunk is written
    interval = sys.getswitchinterval()
    sys.setswitchinterval(PATIENCE)
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            yield
    finally:
        sys.setswitchinterval(interval)


def _told(backlog: Backlog) -> None:
    with backlog.changed:
        backlog.changed.notify_all()


def _evaluated(work: _Work, job: Job) -> Outcome:
    try:
        return Outcome(work.arrival, evaluate_station(work.lines.result(), work.placement, job))
    except StationRefusedError as refused:
        return Outcome(work.arrival, refused)

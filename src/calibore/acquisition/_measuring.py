"""Pictures measured as they come: each result as soon as it is there, in order, with little work under way."""

import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import NamedTuple

from threadpoolctl import threadpool_limits

from calibore.acquisition._backlog import BEAT, Arrival, Backlog
from calibore.images import StationImages
from calibore.profiling import (
    Job,
    Placement,
    Placer,
    StationRefusedError,
    StationResult,
    measure_station,
)

PATIENCE = 5e-4
"""Seconds that the thread which fetches pictures waits for the one that measures; Python's own are ten times that."""


class Outcome(NamedTuple):
    """What became of an arrival: its `result`, why it has none, or None where nobody knows its place."""

    arrival: Arrival
    result: StationResult | StationRefusedError | None


class _Work(NamedTuple):
    arrival: Arrival
    result: Future[StationResult | StationRefusedError]


def measured(
    backlog: Backlog, job: Job, place: Placer, *, workers: int, beat: Callable[[], None]
) -> Generator[Outcome]:
    """Everything that comes through `backlog` until it is closed; `beat` is called several times a second.

    Threads measure, one picture more than there are `workers` at a time, so that what is measured is fresh. Leaving
    the iteration early gives up what is under way.
    """
    working: deque[_Work] = deque()

    def something_to_do() -> bool:
        done = bool(working) and working[0].result.done()
        return done or (len(working) <= workers and len(backlog) > 0) or backlog.closed

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
                result = pool.submit(_measured, arrival.images, placement, job)
                result.add_done_callback(lambda _: _told(backlog))
                working.append(_Work(arrival, result))
            if working and (working[0].result.done() or backlog.closed):
                arrival, result = working.popleft()
                yield Outcome(arrival, result.result())
            elif backlog.closed and not working and not len(backlog):
                return
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def prepared() -> Iterator[None]:
    """Linear algebra keeps to one thread meanwhile, and the thread that fetches pictures need not wait for others."""
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


def _measured(images: StationImages, placement: Placement, job: Job) -> StationResult | StationRefusedError:
    try:
        return measure_station(images, placement, job)
    except StationRefusedError as refused:
        return refused

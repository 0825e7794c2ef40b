"""The threads of this machine, and the one entry to both kinds of crew."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import threadpool_limits

from calibore.crews._cluster import Cluster

Item = TypeVar("Item")
Result = TypeVar("Result")
Workers = int | Cluster
"""Threads of this machine, or a cluster."""
AHEAD = 2
"""Items per worker that may be in work or waiting to be fetched."""


def in_order(items: Iterable[Item], work: Callable[[Item], Result], *, workers: Workers) -> Iterator[Result]:
    """`work(item)` for every item, in order, by `workers`; items are drawn only as fast as they are worked off.

    Linear algebra keeps to one thread meanwhile: its matrices are small, and the cores are busy with stations.
    """
    if isinstance(workers, Cluster):
        yield from workers.in_order(items, work)
        return
    with threadpool_limits(limits=1, user_api="blas"):
        if workers <= 1:
            yield from map(work, items)
        else:
            yield from _on_threads(items, work, workers)


def _on_threads(items: Iterable[Item], work: Callable[[Item], Result], workers: int) -> Iterator[Result]:
    pool = ThreadPoolExecutor(workers, thread_name_prefix="calibore")
    waiting: deque[Future[Result]] = deque()
    try:
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) >= AHEAD * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)

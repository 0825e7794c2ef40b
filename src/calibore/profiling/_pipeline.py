"""Many stations on several threads: results in order, a bounded number of images in memory."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")
AHEAD = 2
"""Items per worker that may be in work or waiting to be fetched."""


def in_order(items: Iterable[Item], work: Callable[[Item], Result], *, workers: int) -> Iterator[Result]:
    """`work(item)` for every item, in order, on `workers` threads; items are drawn only as fast as they are worked off.

    Linear algebra keeps to one thread meanwhile: its matrices are small, and the cores are busy with stations.
    """
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

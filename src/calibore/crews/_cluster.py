"""The machines behind a Dask scheduler: work goes to them in packets of items, a lost one is done again elsewhere.

A packet costs about 30 ms of processor on its way, in the client, the scheduler and the worker together, whatever is in
it, and one ring is measured in 25 ms: so many items go together as take about `PACKET` seconds.
"""

import pickle
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from types import TracebackType
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from calibore.errors import InputError

Item = TypeVar("Item")
Result = TypeVar("Result")
AHEAD = 3
"""Packets per worker thread that may be in work, on their way, or waiting to be fetched."""
PACKET, LARGEST, HEAVIEST = 0.6, 12, 4e6
"""Of a packet: seconds that it should take, items in it and bytes of them (a film's frames) at most."""
COUNTED = 2.0
"""Seconds for which a count of the workers holds."""
PATIENCE = 20
"""Seconds that a scheduler, and then its first worker, are waited for."""
LOSSES = 5
"""Workers that may be lost over one packet before it is given up."""


class Cluster:
    """A connection to the Dask scheduler at `address`, e.g. "tcp://10.0.0.5:8786"; a context manager.

    Its workers need this program at the same version, and must see the same files under the same paths. Raises
    InputError where no scheduler answers, or none of its workers.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self._client = _connected(address)

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()

    @property
    def hands(self) -> int:
        """Worker threads that there are now."""
        return max(sum(self._client.nthreads().values()), 1)

    def in_order(self, items: Iterable[Item], work: Callable[[Item], Result]) -> Iterator[Result]:
        """`work(item)` for every item, in order. Errors that `work` raises are raised here, after what came before."""
        left, task, pace = iter(items), _packed(work), _Pace(self)
        waiting: deque[tuple[list[Item], Any]] = deque()
        try:
            while True:
                while len(waiting) < pace.ahead and (packet := list(islice(left, pace.items))):
                    waiting.append((packet, self._sent(task, packet, pace)))
                if not waiting:
                    return
                packet, future = waiting.popleft()
                results, seconds = self._fetched(future)
                if rest := packet[len(results) :]:
                    waiting.appendleft((rest, self._sent(task, rest, pace)))
                pace.seconds = seconds / len(results)
                yield from results
        finally:
            self._client.cancel([future for _, future in waiting])

    def _sent(self, task: bytes, packet: list[Any], pace: "_Pace") -> Any:
        packed = _packed(packet)
        pace.bytes = len(packed) / len(packet)
        return self._client.submit(_done, task, packed, pure=False, retries=LOSSES)

    def _fetched(self, future: Any) -> tuple[list[Any], float]:
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        try:
            return pickle.loads(future.result())
        except (KilledWorker, FutureCancelledError, TimeoutError) as error:
            raise InputError(
                f"The workers of the Dask scheduler at {self.address} were lost one after the other; look at their "
                "memory and logs, and run this again."
            ) from error


def _packed(thing: Any) -> bytes:
    """In one piece: Dask would handle every function and array in it by itself, at each of its stations."""
    from cloudpickle import dumps

    return dumps(thing)


def _done(task: bytes, packed: bytes) -> bytes:
    """Results of the packed items up to the first that failed, and the seconds they took.

    Only what the first item raises is raised; another that fails comes first in a packet of its own then, so that the
    results before it are not lost. Linear algebra keeps to one thread: it is the items that run side by side.
    """
    work, items = pickle.loads(task), pickle.loads(packed)
    results, began = [], time.perf_counter()
    with threadpool_limits(limits=1, user_api="blas"):
        for item in items:
            try:
                results.append(work(item))
            except Exception:
                if not results:
                    raise
                break
    return _packed((results, time.perf_counter() - began))


@dataclass
class _Pace:
    """How many items go together, and how many packets are under way; an item takes `seconds` and so many `bytes`."""

    crew: Cluster
    seconds: float = PACKET
    bytes: float = 1.0
    _items: int = 1
    _ahead: int = 0
    _counted: float = float("-inf")

    @property
    def ahead(self) -> int:
        if time.monotonic() > self._counted + COUNTED:
            self._ahead, self._counted = AHEAD * self.crew.hands, time.monotonic()
        return self._ahead

    @property
    def items(self) -> int:
        """Of the next packet; they grow by steps."""
        most = min(PACKET / max(self.seconds, 1e-6), HEAVIEST / self.bytes, 2 * self._items, LARGEST)
        self._items = max(int(most), 1)
        return self._items


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError(
            'Running on a cluster needs Dask; install it with pip install "calibore[cluster]", here and on the workers.'
        ) from error
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f'No Dask scheduler answers at "{address}"; start one with `dask scheduler` and give the address that it '
            "prints, e.g. tcp://10.0.0.5:8786."
        ) from error
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        client.close()
        raise InputError(
            f"The Dask scheduler at {address} has no workers; start some with `dask worker {address}`."
        ) from error
    return client

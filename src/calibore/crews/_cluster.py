"""The machines behind a Dask scheduler: work goes to them as whole items, a lost one is done again elsewhere."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from calibore.errors import InputError

Item = TypeVar("Item")
Result = TypeVar("Result")
AHEAD = 3
"""Items per worker thread that may be in work, on their way, or waiting to be fetched."""
PATIENCE = 20
"""Seconds that a scheduler, and then its first worker, are waited for."""
LOSSES = 5
"""Workers that may be lost over one item before it is given up."""


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
        """`work(item)` for every item, in order. Errors that `work` raises are raised here."""
        waiting: deque[Any] = deque()
        try:
            for item in items:
                waiting.append(self._client.submit(_alone, work, item, pure=False, retries=LOSSES))
                if len(waiting) >= AHEAD * self.hands:
                    yield self._fetched(waiting.popleft())
            while waiting:
                yield self._fetched(waiting.popleft())
        finally:
            self._client.cancel(list(waiting))

    def _fetched(self, future: Any) -> Any:
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        try:
            return future.result()
        except (KilledWorker, FutureCancelledError, TimeoutError) as error:
            raise InputError(
                f"The workers of the Dask scheduler at {self.address} were lost one after the other; look at their "
                "memory and logs, and run this again."
            ) from error


def _alone(work: Callable[[Any], Any], item: Any) -> Any:
    """Linear algebra keeps to one thread: it is the items that run side by side."""
    with threadpool_limits(limits=1, user_api="blas"):
        return work(item)


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

"""What measuring a scan of any kind gives, once all of it is in the result folder."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from calibore.rigs import Rig
from calibore.scans import ResultWriter
from calibore.stripe import Stripe

Example = tuple[NDArray[np.generic], Stripe]
"""One image with the line found in it."""


class Progress(Protocol):
    """Called after every station with the number done and how many are expected (None where unknown)."""

    def __call__(self, done: int, total: int | None, /) -> None: ...


class Measured(NamedTuple):
    """The `summary` of a run; `rig` None where the scan has none; an `example` where there are images."""

    summary: dict[str, Any]
    rig: Rig | None
    example: Example | None


Measurement = Callable[[ResultWriter], Measured]
"""Measures a scan that was checked before, into the writer's folder; raises InputError where nothing is left."""

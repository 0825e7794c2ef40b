"""How a run is doing: rates, latency, the latest ring. Of fixed size, however long it runs."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from calibore.acquisition._backlog import now

WINDOW = 5.0
"""Seconds over which a rate is taken."""
SHORTEST, PER_DECADE = 1e-4, 100
"""Latencies [s] are counted in bins of 2.3 % from here on."""


class Latencies:
    """Counts of latencies [s] in bins, so that any number of them takes the same space."""

    def __init__(self) -> None:
        self._counts = np.zeros(8 * PER_DECADE, dtype=np.int64)
        self.largest = math.nan

    def add(self, seconds: float) -> None:
        place = int(PER_DECADE * math.log10(max(seconds, SHORTEST) / SHORTEST))
        self._counts[min(place, self._counts.size - 1)] += 1
        self.largest = max(seconds, self.largest) if self.largest == self.largest else seconds

    def quantile(self, share: float) -> float:
        """Seconds below which `share` of them lie, to 1.2 %; NaN where there are none."""
        total = int(self._counts.sum())
        if total == 0:
            return math.nan
        place = int(np.searchsorted(np.cumsum(self._counts), share * total))
        return SHORTEST * 10 ** ((place + 0.5) / PER_DECADE)


class Rate:
    """Events per second over the last seconds."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, int]] = deque()

    def sample(self, count: int) -> None:
        """So many events have been until now."""
        moment = now()
        if self._samples and moment - self._samples[-1][0] < 0.1:
            return
        self._samples.append((moment, count))
        while moment - self._samples[0][0] > WINDOW:
            self._samples.popleft()

    @property
    def per_second(self) -> float:
        if len(self._samples) < 2:
            return math.nan
        (start, before), (end, after) = self._samples[0], self._samples[-1]
        return (after - before) / (end - start)


@dataclass
class Vitals:
    """What the panel shows; `row` is the latest ring's row of rings.csv, with `station`, `axial_m` and `time_s`."""

    source: str
    begun: float = field(default_factory=now)
    row: Mapping[str, Any] | None = None
    latency: float = math.nan
    latencies: Latencies = field(default_factory=Latencies)
    arriving: Rate = field(default_factory=Rate)
    measuring: Rate = field(default_factory=Rate)
    arrived: int = 0
    rings: int = 0
    dropped: int = 0
    refused: int = 0
    backlog: int = 0
    connected: bool = False
    sentence: str = ""
    """The latest said of the source."""

    @property
    def seconds(self) -> float:
        """Since the run began."""
        return now() - self.begun

    def ring(self, row: Mapping[str, Any], latency: float) -> None:
        """A ring was measured, stored and is about to be told."""
        self.row, self.latency = row, latency
        self.rings += 1
        self.latencies.add(latency)

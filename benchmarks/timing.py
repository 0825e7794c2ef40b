"""Paired timing: every round runs all contestants in random order, and a result is the median of per-round ratios."""

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

BOOTSTRAPS = 2000


@dataclass(frozen=True)
class Comparison:
    """`milliseconds` median per contestant; `ratio` peer over contestant: (median, low, high) of a 95 % bootstrap."""

    milliseconds: dict[str, float]
    ratio: dict[str, tuple[float, float, float]]

    def rows(self) -> list[str]:
        """Markdown table rows: name, ms, ratio with interval."""
        return [
            f"| {name} | {self.milliseconds[name]:.2f} | {r:.2f} ({low:.2f} ... {high:.2f}) |"
            for name, (r, low, high) in self.ratio.items()
        ]


def pin_to_one_core() -> None:
    """Keep this process on one core, where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[-1]})


def compare(
    contestants: Mapping[str, Callable[[], object]],
    *,
    peer: str,
    rounds: int,
    rng: np.random.Generator,
    clock: Callable[[], float] = time.perf_counter,
) -> Comparison:
    """Time `contestants` over `rounds`; the peer runs twice per round, its second time being the control.

    `clock` tells seconds: of the wall, or of the processor (`time.process_time`) where other jobs share it.
    """
    names = [*contestants, f"{peer} (control)"]
    calls = dict(contestants) | {names[-1]: contestants[peer]}
    seconds = {name: np.empty(rounds) for name in names}
    for call in contestants.values():
        call()
    for i in range(rounds):
        for name in rng.permutation(names):
            start = clock()
            calls[name]()
            seconds[name][i] = clock() - start
    ratio = {name: _median_interval(seconds[peer] / seconds[name], rng) for name in names}
    return Comparison({name: 1e3 * float(np.median(s)) for name, s in seconds.items()}, ratio)


def _median_interval(ratios: np.ndarray, rng: np.random.Generator) -> tuple[float, float, float]:
    draws = np.median(rng.choice(ratios, (BOOTSTRAPS, ratios.size)), axis=1)
    low, high = np.quantile(draws, [0.025, 0.975])
    return float(np.median(ratios)), float(low), float(high)

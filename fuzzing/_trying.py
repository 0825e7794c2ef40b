"""One entry tried many times in this process: every different fault is kept with the files that cause it."""

import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from fuzzing._entries import ENTRIES
from fuzzing._judging import fault_of, limit_memory

SAID = "fault.txt"


def attempts(name: str, scratch: Path, *, seed: int) -> Iterator[str | None]:
    """What was wrong in each call of the attempts [seed, 0], [seed, 1], ... of an entry; its files: scratch/case."""
    entry, number = ENTRIES[name], 0
    entry.prepare(scratch)
    while True:
        for call in entry.attempt(np.random.default_rng([seed, number]), scratch):
            fault = fault_of(call)
            yield fault and f"attempt [{seed}, {number}] of {name}: {fault}"
        number += 1


def head_of(fault: str) -> str:
    """What and where: alike in all faults with one cause."""
    return fault.partition(": ")[2].partition(": ")[0]


def work(name: str, home: Path, *, seed: int, minutes: float) -> None:
    """Attempts for some minutes of the processor, or until SIGINT; tells how many as libFuzzer does."""
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    count, scratch = 0, home / name
    every = attempts(name, scratch, seed=seed)
    try:
        for fault in every:
            if count == 0:
                limit_memory()
            count += 1
            _noted(fault, scratch)
            if time.process_time() > 60 * minutes:
                break
    finally:
        print(f"stat::number_of_executed_units: {count}", flush=True)


def _noted(fault: str | None, scratch: Path) -> None:
    if fault is None:
        return
    place = scratch / "found" / "".join(letter if letter.isalnum() else "-" for letter in head_of(fault))[:90]
    if place.exists():
        return
    print(f"SUMMARY: {fault.splitlines()[0][:400]}", flush=True)
    place.mkdir(parents=True)
    if (scratch / "case").is_dir():
        with suppress(OSError):
            shutil.copytree(scratch / "case", place, dirs_exist_ok=True)
    (place / SAID).write_text(fault, encoding="utf-8")

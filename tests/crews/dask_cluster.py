"""A real Dask scheduler and real worker processes on this machine: for the tests and the benchmark."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DASK = Path(sys.executable).with_name("dask")
PATIENCE = 30.0
"""Seconds that a scheduler may take to start."""


@contextmanager
def dask_cluster(folder: Path, *, workers: int) -> Iterator[tuple[str, list[subprocess.Popen]]]:
    """The scheduler's address and the worker processes, one thread each; all are gone afterwards."""
    place = folder / "scheduler.json"
    started = [_started(folder, "scheduler", "--scheduler-file", place, "--port", "0")]
    try:
        address = _address(place)
        started += [_started(folder, "worker", address, "--nthreads", "1", "--no-nanny") for _ in range(workers)]
        yield address, started[1:]
    finally:
        for process in started:
            process.kill()
            process.wait()


def _started(folder: Path, *words: Any) -> subprocess.Popen:
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    command = [str(DASK), *map(str, words), "--no-dashboard"]
    return subprocess.Popen(command, cwd=folder, env=dict(os.environ), **quiet)


def _address(place: Path) -> str:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if place.is_file() and place.stat().st_size:
            return json.loads(place.read_text(encoding="utf-8"))["address"]
        time.sleep(0.1)
    raise RuntimeError(f"The Dask scheduler has not started within {PATIENCE:g} s.")

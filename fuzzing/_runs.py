"""One entry after the other, each in a process of its own that can be paused, for some minutes of the processor."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from fuzzing import _native
from fuzzing._entries import ENTRIES
from fuzzing._ledger import Done, add, ledger

POLL = 0.5
NICE = 19
RUNS = re.compile(r"^stat::number_of_executed_units:\s*(\d+)", re.MULTILINE)
PROGRESS = re.compile(r"^#(\d+)\s", re.MULTILINE)
ROOT = Path(__file__).parents[1]
ENDED = threading.Event()
MOST_FAULTS = 50
"""Faults of one entry after which it is left alone."""


def names() -> tuple[str, ...]:
    """Of all entries, those of the compiled code first."""
    return (*_native.TARGETS, *ENTRIES)


def every_entry(asked: Sequence[str]) -> list[str]:
    """Those asked for, or all; the targets among them built."""
    unknown = set(asked) - set(names())
    if unknown:
        raise SystemExit(f"no entry {', '.join(sorted(unknown))}; there are {', '.join(names())}")
    chosen = list(asked or names())
    if set(chosen) & set(_native.TARGETS):
        _native.build()
    return chosen


def end_on_signals() -> None:
    """From now on SIGINT and SIGTERM end what runs, and what it has done is noted."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ENDED.set())


def run(name: str, home: Path, *, minutes: float, seed: int, pause: Path | None) -> None:
    """Runs of an entry until it has had its minutes: a target's run ends with a fault."""
    while not ENDED.is_set():
        done = ledger(home).get(name, Done())
        if done.seconds >= 60 * minutes or done.faults >= MOST_FAULTS:
            return
        add(home, name, _one_run(name, home, seconds=60 * minutes - done.seconds, seed=seed + done.runs, pause=pause))


def _one_run(name: str, home: Path, *, seconds: float, seed: int, pause: Path | None) -> Done:
    while not ENDED.is_set() and _paused(pause):
        time.sleep(POLL)
    if name in _native.TARGETS:
        command, env = _native.command(name, home, seed=seed), _native.environment()
    else:
        options = ["--attempt", "--seed", str(seed), "--minutes", "inf", "--home", str(home)]
        command, env = [sys.executable, "-m", "fuzzing", name, *options], dict(os.environ)
    log = home / f"{name}.log"
    with log.open("wb") as file:
        process = subprocess.Popen(
            command, stdout=file, stderr=file, env=env, cwd=ROOT, preexec_fn=lambda: os.nice(NICE) and None
        )
        try:
            used = _watched(process, seconds=seconds, pause=pause)
        finally:
            _ended(process)
    text = log.read_text(errors="replace")
    found = RUNS.findall(text) or PROGRESS.findall(text) or ["0"]
    faults = text.count("SUMMARY: ") + (process.returncode < 0 and process.returncode != -signal.SIGINT)
    if faults:
        print(f"{name}: {faults} faults, see {log} and {home / name / 'found'}", flush=True)
        log.replace(home / f"{name}-{seed}.log")
    return Done(int(found[-1]), used, faults, 1)


def _watched(process: subprocess.Popen[bytes], *, seconds: float, pause: Path | None) -> float:
    """Seconds of the processor that it had when it ended, or was to end; it is stopped while `pause` exists."""
    used, stopped = 0.0, False
    while process.poll() is None and used < seconds and not ENDED.is_set():
        time.sleep(POLL)
        used = _processor(process.pid) or used
        if _paused(pause) != stopped:
            stopped = not stopped
            process.send_signal(signal.SIGSTOP if stopped else signal.SIGCONT)
    process.send_signal(signal.SIGCONT)
    return used


def _paused(pause: Path | None) -> bool:
    return pause is not None and pause.exists()


def _ended(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _processor(pid: int) -> float | None:
    try:
        cells = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return None
    return (int(cells[11]) + int(cells[12])) / os.sysconf("SC_CLK_TCK")

"""How a live run shows itself: a panel on a terminal, a line now and then in a log, JSON for programs, or nothing."""

import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from calibore.cli._profile import as_json

if TYPE_CHECKING:
    from calibore.acquisition import Vitals, Watch

EVERY = 5.0
"""Seconds between two lines of a log."""
REDRAWN = 0.2
"""Seconds between two drawings of the panel."""
UP, CLEAR = "\x1b[{}A\r", "\x1b[J"


@contextmanager
def watch_of(*, unit: str, json: bool, quiet: bool) -> Iterator["Watch"]:
    """Who watches a run that writes to this standard output."""
    if json:
        yield _Json()
    elif quiet:
        yield _Quiet()
    elif sys.stdout.isatty():
        panel = _Panel(unit)
        try:
            yield panel
        finally:
            panel.leave()
    else:
        yield _Log(unit)


class _Quiet:
    """Tells only what is said, on standard error."""

    def ring(self, vitals: "Vitals") -> None:
        pass

    def beat(self, vitals: "Vitals") -> None:
        pass

    def say(self, sentence: str) -> None:
        typer.echo(sentence, err=True)


class _Json(_Quiet):
    """A line for every ring: its row of rings.csv in SI, and how late it is."""

    def ring(self, vitals: "Vitals") -> None:
        late = {"latency_s": vitals.latency, "waiting": vitals.backlog, "dropped": vitals.dropped}
        print(as_json({**(vitals.row or {}), **late}, indent=None), flush=True)


class _Log(_Quiet):
    """A line every few seconds."""

    def __init__(self, unit: str) -> None:
        self._unit, self._told = unit, time.monotonic()

    def beat(self, vitals: "Vitals") -> None:
        from calibore.acquisition import plain_line

        if time.monotonic() - self._told >= EVERY:
            self._told = time.monotonic()
            typer.echo(plain_line(vitals, unit=self._unit))


class _Panel(_Quiet):
    """A few lines that are drawn again in place; what is said scrolls away above them."""

    def __init__(self, unit: str) -> None:
        self._unit, self._drawn, self._lines = unit, 0.0, 0

    def beat(self, vitals: "Vitals") -> None:
        if time.monotonic() - self._drawn >= REDRAWN:
            self._draw(vitals)

    def say(self, sentence: str) -> None:
        self._erase()
        typer.echo(sentence, err=True)

    def leave(self) -> None:
        """The last state stays on the screen."""
        self._lines = 0

    def _draw(self, vitals: "Vitals") -> None:
        from calibore.acquisition import panel

        self._erase()
        width = shutil.get_terminal_size().columns - 1  # a line that wraps could not be drawn again in place
        lines = [line[:width] for line in panel(vitals, unit=self._unit)]
        sys.stdout.write("".join(f"{line}\n" for line in lines))
        sys.stdout.flush()
        self._lines, self._drawn = len(lines), time.monotonic()

    def _erase(self) -> None:
        if self._lines:
            sys.stdout.write(UP.format(self._lines) + CLEAR)
            sys.stdout.flush()
            self._lines = 0

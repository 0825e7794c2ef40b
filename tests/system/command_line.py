"""The `calibore` command as a user runs it: in this process where that is the same, else in one of its own."""

import io
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from calibore.cli import main

PATIENCE = 120  # s, for one command on a machine that has other things to do


@dataclass(frozen=True)
class Outcome:
    """Exit status, standard output and standard error of one command."""

    status: int
    out: str
    err: str

    @property
    def sentence(self) -> str:
        """What a failed command says: one line, no traceback, nothing on standard output."""
        assert self.out == ""
        assert self.err.startswith("calibore: ")
        assert self.err.count("\n") == 1
        assert "Traceback" not in self.err
        return self.err.removeprefix("calibore: ").strip()


def calibore(*arguments: object) -> Outcome:
    """`calibore` with these arguments, in this process."""
    out, err, status = io.StringIO(), io.StringIO(), 0
    argv = ["calibore", *map(str, arguments)]
    with patch.object(sys, "argv", argv), redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as leaving:
            status = int(leaving.code or 0)
    return Outcome(status, out.getvalue(), err.getvalue())


def started(*arguments: object, cwd: Path | None = None, prepare: Callable[[], None] | None = None, **options: object):
    """`calibore` in a process of its own; `prepare` runs in it before Python does."""
    return subprocess.Popen(
        [sys.executable, "-m", "calibore", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        cwd=cwd,
        preexec_fn=prepare,
        env={**os.environ, "MPLBACKEND": "Agg"},
        **options,
    )


def outcome_of(process: subprocess.Popen[str]) -> Outcome:
    """The outcome of a started command."""
    out, err = process.communicate(timeout=PATIENCE)
    return Outcome(process.returncode, out, err)


def profile(scan: Path, *more: object, out: Path | None = None) -> Outcome:
    """`calibore profile` without pictures; the result goes beside the scan."""
    return calibore("profile", scan, "--out", out or scan.parent / "out", "--no-pictures", *more)


def stray_files(out: Path) -> list[str]:
    """What a run has left beside its result."""
    return sorted(path.name for path in out.parent.iterdir() if path.name.startswith(f".{out.name}."))

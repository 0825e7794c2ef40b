"""A run that dies leaves the old result or none; the next one works as if nothing had happened."""

import os
import shutil
import signal
import sys
import time
from pathlib import Path
from subprocess import Popen

import numpy as np
import pytest
from command_line import calibore, outcome_of, profile, started, stray_files
from conftest import STATIONS, small_survey

from calibore.simulation import simulate_scan

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
KILLS = 8
AFTER = 0.6
"""Seconds that a run takes to write its result once it has begun, about."""
BEGUN = 60.0
"""Seconds after which a run that has not begun will not."""
INTERRUPTED = 130


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Long enough that a run can be hit while it measures: the small survey three times over."""
    folder = tmp_path_factory.mktemp("long") / "survey"
    simulate_scan(folder, small_survey(), seed=3)
    for image in sorted(folder.glob("*.png")):
        for station in range(STATIONS, 3 * STATIONS, STATIONS):
            number = int(image.name.split()[1]) + station
            os.link(image, folder / f"pipe {number:03d} 0.png")
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a result with its bytes."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def complete(survey: Path) -> dict[str, bytes]:
    """The result that an undisturbed run gives."""
    out = survey.parent / "complete"
    assert profile(survey, out=out).status == 0
    return contents(out)


def wait_until_begun(process: Popen[str], out: Path) -> None:
    """Until the run writes its result beside `out`, or has ended."""
    deadline = time.monotonic() + BEGUN
    while process.poll() is None and time.monotonic() < deadline:
        if any(name.startswith(f".{out.name}.partial-") for name in stray_files(out)):
            return
        time.sleep(0.002)


def hit(survey: Path, out: Path, number: int, delay: float) -> int:
    """Send the signal `delay` seconds after the run has begun to write; returns the exit status."""
    process = started("profile", survey, "--out", out, "--no-pictures")
    wait_until_begun(process, out)
    time.sleep(delay)
    process.send_signal(number)
    return outcome_of(process).status


@pytest.mark.parametrize("old", [False, True], ids=["nothing there", "old result there"])
def test_killed_at_any_moment_a_run_leaves_the_old_result_or_none_and_the_next_run_works(
    survey, complete, tmp_path, old
):
    out, killed = tmp_path / "out", 0
    if old:
        assert profile(survey, out=out).status == 0
    for delay in np.random.default_rng(7 + old).uniform(0.0, AFTER, KILLS // 2):
        killed += hit(survey, out, signal.SIGKILL, float(delay)) == -signal.SIGKILL
        if out.exists():
            assert contents(out) == complete
        else:
            assert not old
        assert profile(survey, out=out).status == 0
        assert contents(out) == complete
        assert os.listdir(tmp_path) == ["out"]
        if not old:
            shutil.rmtree(out)
    assert killed > 0


def test_interrupted_by_the_keyboard_a_run_says_so_and_cleans_up(survey, complete, tmp_path):
    out = tmp_path / "out"
    assert profile(survey, out=out).status == 0
    process = started("profile", survey, "--out", out, "--no-pictures")
    wait_until_begun(process, out)
    process.send_signal(signal.SIGINT)
    outcome = outcome_of(process)
    assert outcome.status == INTERRUPTED
    assert outcome.out == ""
    assert outcome.err == "calibore: interrupted; the result folder is as it was before.\n"
    assert contents(out) == complete
    assert os.listdir(tmp_path) == ["out"]


def test_an_old_result_stays_when_a_later_run_fails(scan, tmp_path):
    out = tmp_path / "out"
    assert profile(scan).status == 0
    before = contents(out)
    for image in scan.glob("*.png"):
        image.unlink()
        image.write_bytes(b"no picture")
    assert profile(scan).status == 1
    assert contents(out) == before
    assert not stray_files(out)


def test_a_run_that_finds_another_one_writing_says_so(survey, tmp_path):
    out = tmp_path / "out"
    process = started("profile", survey, "--out", out, "--no-pictures")
    wait_until_begun(process, out)
    process.send_signal(signal.SIGSTOP)
    try:
        outcome = profile(survey, out=out)
        assert outcome.status == 1
        assert "is being written by another run; wait for it to end" in outcome.sentence
    finally:
        process.send_signal(signal.SIGCONT)
    assert outcome_of(process).status == 0
    assert os.listdir(tmp_path) == ["out"]


def test_two_runs_give_the_same_bytes_in_every_file_pictures_and_exports_included(scan, tmp_path):
    exports = [word for name in ("text3", "csv", "netcdf", "ply", "las", "laz") for word in ("--export", name)]
    results = []
    for name, workers in (("first", 1), ("second", 4)):
        outcome = calibore("profile", scan, "--out", tmp_path / name, "--workers", workers, *exports)
        assert outcome.status == 0
        results.append(contents(tmp_path / name))
    assert results[0].keys() == results[1].keys()
    assert {"profile.nc", "points.las", "report.html"} <= results[0].keys()
    assert [name for name in results[0] if results[0][name] != results[1][name]] == []

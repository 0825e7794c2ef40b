"""Memory does not grow with the number of stations."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import STATIONS, small_rig, small_survey

from calibore.simulation import simulate_scan

FEW, MANY = 12, 48
MARGIN = 20.0
"""MiB: two thirds of a chunk of points (64 Ki of 76 bytes each) and what allocators keep; the further images alone have
32 MiB, what is found in them as much again."""
PROGRAM = """
import resource, sys
from calibore.cli import main
try:
    main()
finally:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, file=sys.stderr)
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate_scan(tmp_path_factory.mktemp("memory") / "survey", small_survey(small_rig(640, 480)), seed=2)


def peak(pictures: Path, folder: Path, stations: int) -> float:
    """Most memory [MiB] that profiling `stations` stations has taken."""
    folder.mkdir()
    for name in ("scan.toml", "rig.toml"):
        shutil.copy(pictures / name, folder)
    for number in range(stations):
        os.link(pictures / f"pipe {number % STATIONS:03d} 0.png", folder / f"pipe {number:03d} 0.png")
    command = [sys.executable, "-c", PROGRAM, "profile", folder, "--out", folder.parent / f"out {stations}"]
    run = subprocess.run([*command, "--no-pictures", "--workers", "2"], capture_output=True, text=True, check=True)
    assert run.stdout.startswith(f"{stations} stations")
    return float(run.stderr)


@pytest.mark.skipif(sys.platform != "linux", reason="needs peak memory in KiB, as Linux gives it")
def test_four_times_the_stations_take_no_more_memory(pictures, tmp_path):
    few, many = (peak(pictures, tmp_path / str(stations), stations) for stations in (FEW, MANY))
    assert many - few < MARGIN

"""What is missing or wrong in a side-facing scan is told in one sentence; what is left is measured."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from side_scans import scan_of, side_survey

from calibore.errors import InputError
from calibore.profiling import profile_scan
from calibore.scans import open_profile

FORWARD = """format = "calibore-rig/1"
configuration = "perpendicular-plane"
[camera]
width = 256
height = 192
lens = "sine-law"
k = 100.0
principal_point = [128.0, 96.0]
[laser]
baseline = "60 mm"
"""
TABLE = "station,axial_m\n0,0.0\n1,0.02\n"


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scan_of(side_survey(3, angles=(0, 50, 100, 150), stations=2), tmp_path_factory.mktemp("side") / "scan")


@pytest.fixture
def scan(sound: Path, tmp_path: Path) -> Path:
    return shutil.copytree(sound, tmp_path / "scan")


def edited(name: str, pattern: str, text: str) -> Callable[[Path], None]:
    """Replaces what matches `pattern` in the file `name` of a scan."""

    def edit(scan: Path) -> None:
        before = (scan / name).read_text()
        after = re.sub(pattern, text, before, flags=re.MULTILINE)
        assert after != before
        (scan / name).write_text(after)

    return edit


def one_stop(scan: Path) -> None:
    for path in scan.glob("side *.png"):
        if " 050 " not in path.name:
            path.unlink()


def no_angular(scan: Path) -> None:
    edited("scan.toml", "^axial.*", 'table = "stops.csv"')(scan)
    edited("scan.toml", "^angular.*", "")(scan)
    (scan / "stops.csv").write_text(TABLE)


MISTAKES = {
    "a forward rig": (lambda scan: (scan / "rig.toml").write_text(FORWARD), "perpendicular-plane rig, but .*angular"),
    "no field": (edited("scan.toml", r"\{angular:03d\}", "000"), "needs both the field {angular} and motion.angular"),
    "no motion": (edited("scan.toml", "^angular.*", ""), "gives no angular"),
    "no motion, but a table": (no_angular, r"add motion\.angular"),
    "a step of 0": (edited("scan.toml", "^angular.*", 'angular = {origin="0 deg", step="0 deg"}'), "at one clock"),
    "one stop": (one_stop, "all images are of angular stop 50: that is one strip"),
    "another camera": (edited("rig.toml", "^width.*", "width = 300"), "it is 256 x 192 px but .* 300 x 192 px"),
    "another colour": (edited("rig.toml", '"red"', '"blue"'), "no laser line down the image"),
    "a fine grid": (edited("scan.toml", r"\Z", '\n[grid]\naxial_step = "1 um"\n'), "finer than the rows of the pict"),
    "another pipe": (edited("scan.toml", "^nominal_radius.*", 'nominal_radius = "3 m"'), "does not see a wall"),
}


@pytest.mark.parametrize("mistake", list(MISTAKES))
def test_a_mistake_is_told_in_one_sentence(scan: Path, mistake: str) -> None:
    make, told = MISTAKES[mistake]
    make(scan)
    with pytest.raises(InputError, match=told) as caught:
        profile_scan(scan, scan.parent / "out")
    assert "\n" not in str(caught.value)
    assert not (scan.parent / "out").exists()


def test_a_heads_rig_with_a_scan_of_rings_is_told_so(scan: Path) -> None:
    edited("scan.toml", r"\{angular:03d\} ", "")(scan)
    edited("scan.toml", "^angular.*", "")(scan)
    for station in range(2):
        (scan / f"side {station:03d} 000 0.png").rename(scan / f"side {station:03d} 0.png")
    with pytest.raises(InputError, match=r"side-facing rig, but .* rings ahead of the camera"):
        profile_scan(scan, scan.parent / "out")


def test_exit_status_is_1_where_nothing_can_be_measured_and_3_where_something(scan: Path) -> None:
    def status() -> int:
        command = [sys.executable, "-m", "calibore", "profile", str(scan), "--out", str(scan.parent / "out")]
        return subprocess.run([*command, "--no-pictures"], check=False, capture_output=True).returncode

    (scan / "side 001 050 0.png").write_bytes(b"no picture")
    assert status() == 3
    one_stop(scan)
    assert status() == 1


def test_missing_stops_and_broken_pictures_are_named_and_the_rest_is_measured(scan: Path) -> None:
    (scan / "side 000 050 0.png").unlink()
    (scan / "side 001 100 0.png").write_bytes((scan / "side 001 100 0.png").read_bytes()[:700])
    summary = profile_scan(scan, scan.parent / "out")
    assert summary["counts"]["images"] == 6
    assert summary["skipped"][0]["image"] == "side 001 100 0.png"
    assert any("station 0 angular stop 50" in warning for warning in summary["warnings"])
    found = np.isfinite(open_profile(scan.parent / "out").radius.values).any(axis=0)
    np.testing.assert_array_equal(np.flatnonzero(found), [0, 50, 100, 150])


def test_a_table_may_say_where_the_carriage_stood(scan: Path) -> None:
    edited("scan.toml", "^axial.*", 'table = "stops.csv"')(scan)
    (scan / "stops.csv").write_text("station,axial_m\n1,2.0\n")
    summary = profile_scan(scan, scan.parent / "out")
    assert summary["counts"]["stations"] > 0
    assert any("no row for 1 station" in warning for warning in summary["warnings"])
    assert abs(open_profile(scan.parent / "out").axial.values.mean() - 2.0) < 0.1


def test_a_wall_outside_the_search_limits_has_no_number(scan: Path) -> None:
    edited("scan.toml", r"\Z", "\n[search]\ninner = 0.5\nouter = 1.0001\n")(scan)
    profile_scan(scan, scan.parent / "out")
    profile = open_profile(scan.parent / "out")
    assert np.nanmax(profile.radius.values) <= 1.001 * profile.attrs["nominal_radius"]

"""Scans compared as a user compares them: from pictures and voltages to the answer, against what is known of them."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import calibore, profile

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
INCH = 0.0254
needs_data = pytest.mark.skipif(not SIMULATED.exists(), reason=f"{SIMULATED} is not there: nothing real is compared")


def compared(out, *arguments):
    done = calibore("compare", *arguments, "--out", out, "--no-pictures")
    assert done.status == 0, done.err
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def test_a_scan_and_its_own_result_do_not_differ(scan, tmp_path):
    """The scan is profiled on the way, into the result."""
    assert profile(scan, out=tmp_path / "result").status == 0
    found = compared(tmp_path / "out", scan, tmp_path / "result")
    assert found["question"] == "change"
    assert found["regions"] == []
    assert found["errors"]["rms_m"] < 1e-8
    assert "profile-a" in found["files"]
    assert (tmp_path / "out" / "profile-a" / "profile.zarr").exists()
    assert "profile-b" not in found["files"]


def test_pictures_that_cannot_be_used_show_in_the_exit_status(scan, tmp_path):
    assert profile(scan, out=tmp_path / "result").status == 0
    picture = sorted(scan.glob("*.png"))[-1]
    picture.unlink()
    picture.write_bytes(b"no picture")
    done = calibore("compare", scan, tmp_path / "result", "--out", tmp_path / "out", "--no-pictures")
    assert done.status == 3
    assert done.out


@needs_data
def test_laser_against_touch_finds_how_they_were_mounted(tmp_path):
    """Clock within 0.05 deg, shift within 0.003 in, axial within 0.03 in, each within its own 95 % interval."""
    found = compared(tmp_path / "out", SIMULATED / "plane-12in", SIMULATED / "tactile")
    assert (found["question"], found["reference"]) == ("error", "tactile")
    rig, probe = (json.loads((SIMULATED / name / "case.json").read_text()) for name in ("plane-12in", "tactile"))
    turned = np.array(probe["probe_pose"]["R"])[:2, :2].T
    shift = turned @ (np.array([rig["rig_dx_in"], -rig["rig_up_in"]]) - probe["probe_pose"]["t"][:2]) * INCH
    roll = np.radians(rig["rig_roll_deg"]) + np.arctan2(turned[1, 0], turned[0, 0])
    truth = {"roll": roll, "shift_x": shift[0], "shift_y": shift[1], "axial": 0.0}
    limits = {"roll": np.radians(0.05), "shift_x": 0.003 * INCH, "shift_y": 0.003 * INCH, "axial": 0.03 * INCH}
    motion, u = found["registration"]["motion"], found["registration"]["u"]
    for name, value in truth.items():
        assert abs(motion[name] - value) < min(limits[name], 1.96 * u[name]), name
    assert 0.92 < found["errors"]["inside_95"] < 0.995
    assert found["errors"]["rms_m"] < 0.006 * INCH


@needs_data
def test_growth_between_two_epochs_is_found_where_it_is_and_nowhere_else(tmp_path):
    """0.05 in at 5 in and 272 deg: place within 0.3 in, size within 0.01 in."""
    found = compared(tmp_path / "out", SIMULATED / "epochs" / "A", SIMULATED / "epochs" / "B")
    (region,) = found["regions"]
    assert region["axial_m"]["value"] == pytest.approx(5 * INCH, abs=0.3 * INCH)
    assert np.degrees(region["clock_rad"]["value"]) == pytest.approx(272, abs=0.3 / 6 * 180 / np.pi)
    assert region["depth_m"]["value"] == pytest.approx(-0.05 * INCH, abs=0.01 * INCH)
    assert abs(region["depth_m"]["value"] + 0.05 * INCH) < 1.96 * region["depth_m"]["u"]

"""Surveys of an independent renderer, compared without a human hand; their true motion and change are known."""

from pathlib import Path

import numpy as np
import pytest

from calibore.calibration import calibrate, write_calibration
from calibore.comparison import compared
from calibore.profiling import profile_scan
from calibore.scans import read_profile

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
INCH = 0.0254

pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason=f"the shared surveys are not at {SHARED}")


def measured(name, folder, **options):
    profile_scan(SHARED / name, folder / name.replace("/", "-"), **options)
    return read_profile(folder / name.replace("/", "-"))


@pytest.mark.slow
def test_a_dent_that_grew_between_two_epochs_is_the_only_change(tmp_path):
    found = compared(measured("epochs/B", tmp_path), measured("epochs/A", tmp_path), epochs=True)
    (region,) = found.changes.regions
    assert abs(region.axial.value / INCH - 5.0) < 0.3
    assert abs(np.degrees(region.clock.value) - 272) < 3
    assert abs(region.depth.value / INCH + 0.050) < 0.010


@pytest.mark.slow
def test_a_laser_profile_finds_its_place_on_the_tactile_one(tmp_path):
    write_calibration(calibrate("probe", SHARED / "tactile"), tmp_path / "probe.toml")
    touched = measured("tactile", tmp_path, probe=tmp_path / "probe.toml")
    registration = compared(measured("plane-12in", tmp_path), touched, epochs=False).registration
    motion, u = registration.motion, registration.u
    # Table 8.2 places the laser's rig, and the tactile probe was turned by -0.35 deg and stood 0.012, 0.008 in aside
    assert abs(np.degrees(motion.roll) - 0.9130) < min(0.05, 1.96 * np.degrees(u("roll")))
    assert abs(motion.shift_x / INCH + 0.00091) < min(0.003, 3 * u("shift_x") / INCH)
    assert abs(motion.shift_y / INCH - 0.00219) < min(0.003, 3 * u("shift_y") / INCH)
    assert abs(motion.axial / INCH) < min(0.03, 1.96 * u("axial") / INCH)

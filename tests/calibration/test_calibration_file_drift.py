"""A calibration FILE to which somebody adds [drift]: what was calibrated stays what it was; what measures is told."""

import json

import numpy as np
import pytest
from calibration_examples import calibration
from typer.testing import CliRunner

from calibore.calibration import difference, read_calibration, recomputed_covariance, write_calibration
from calibore.cli import app
from calibore.rigs import moved, read_rig, write_rig

DRIFT = '\n[drift]\nbaseline = "0.4 mm"\nk = 3.0\n'


@pytest.fixture
def file(tmp_path):
    """The calibration, written, without and with drift."""
    write_calibration(calibration(2), tmp_path / "rig.toml")
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "drifted.toml").write_text(text + DRIFT)
    return tmp_path


def test_drift_is_no_part_of_the_calibration(file):
    plain, drifted = read_calibration(file / "rig.toml"), read_calibration(file / "drifted.toml")
    assert np.array_equal(plain.covariance.matrix, drifted.covariance.matrix)
    assert np.array_equal(plain.rig.covariance.matrix, drifted.rig.covariance.matrix)
    assert plain.settings == drifted.settings
    assert plain.warnings == drifted.warnings
    again = [recomputed_covariance(file / name).matrix for name in ("rig.toml", "drifted.toml")]
    assert np.array_equal(*again)


def test_what_measures_with_it_knows_of_the_drift(file):
    plain, drifted = read_rig(file / "rig.toml"), read_rig(file / "drifted.toml")
    added = np.diag(drifted.covariance.matrix - plain.covariance.matrix)
    assert dict(zip(plain.covariance.names, added, strict=True)) == pytest.approx(
        {name: {"laser.baseline": 1.6e-7, "camera.k": 9.0}.get(name, 0.0) for name in plain.covariance.names},
        rel=1e-6,
        abs=1e-12,
    )
    assert drifted.degrees_of_freedom == plain.degrees_of_freedom


def test_show_says_the_same_with_drift(file):
    run = [
        CliRunner().invoke(app, ["calibrate", "show", str(file / n), "--json"]) for n in ("rig.toml", "drifted.toml")
    ]
    assert [one.exit_code for one in run] == [0, 0]
    said = [json.loads(one.stdout) for one in run]
    differs = {key for key in said[0] if said[0][key] != said[1].get(key)}
    assert differs <= {"file", "out", "path"}


def test_drift_hides_no_change_between_two_calibrations(file):
    """Asked is whether the camera has changed; what it was expected to change by would answer that with no."""
    old = read_rig(file / "rig.toml")
    u = float(old.covariance.u[old.covariance.names.index("laser.baseline")])
    assert u < 4e-5
    new = moved(old, {"laser.baseline": 12 * u})
    write_rig(new.knowing(old.covariance, old.degrees_of_freedom), file / "new.toml")
    run = [
        CliRunner().invoke(app, ["calibrate", "diff", str(file / name), str(file / "new.toml")])
        for name in ("rig.toml", "drifted.toml")
    ]
    assert [one.exit_code for one in run] == [0, 0], run[1].output
    assert run[0].stdout == run[1].stdout
    told = [difference(one, new, nominal_radius=0.1524).verdict("mm") for one in (old, read_rig(file / "drifted.toml"))]
    assert run[0].stdout.strip() == told[0]
    assert told[0] != told[1]

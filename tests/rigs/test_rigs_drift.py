"""[drift] of a rig file: how far its parameters may have moved is added to how well they were calibrated."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.rigs import read_camera, read_rig, read_rig_or_camera, write_rig
from calibore.uncertainty import Distribution

CAMERA = """
format = "calibore-rig/1"
configuration = "single-cone"
[camera]
width = 1024
height = 768
lens = "sine-law"
k = 571.0
principal_point = [512.0, 384.0]
"""
LASER = """
[laser]
baseline = "3.0 in"
aim = "11.4 deg"
half_angle = "25.5 deg"
"""
CALIBRATION = """
[calibration]
parameters = ["laser.baseline", "laser.aim", "camera.k"]
covariance = [[4e-8, 2e-7, 0.0], [2e-7, 4e-6, 0.0], [0.0, 0.0, 0.25]]
parameter_degrees_of_freedom = [12.0, 12.0, 30.0]
degrees_of_freedom = 76
"""


def read(tmp_path, *tables, drift=True):
    path = tmp_path / "rig.toml"
    path.write_text("\n".join((CAMERA, LASER, *tables)))
    return read_rig(path, drift=drift)


def u_of(covariance):
    return dict(zip(covariance.names, covariance.u.tolist(), strict=True))


def test_drift_adds_its_variance_to_a_calibration_and_leaves_what_parameters_share(tmp_path):
    calibrated = read(tmp_path, CALIBRATION).covariance
    widened = read(tmp_path, CALIBRATION, '[drift]\nbaseline = "0.3 mm"\nhalf_angle = "0.1 deg"\nk = 2').covariance
    assert widened.names == (*calibrated.names, "laser.half_angle")
    added = widened.matrix.copy()
    added[:3, :3] -= calibrated.matrix
    assert np.allclose(added, np.diag([9e-8, 0.0, 4.0, np.radians(0.1) ** 2]), rtol=1e-12, atol=1e-20)


def test_drift_adds_its_variance_to_what_is_stated_with_its_correlations(tmp_path):
    stated = (
        '[uncertainty]\nbaseline = "0.4 mm"\naim = "0.1 deg"\nprincipal_point = 0.4\nstripe = 0.2\n'
        'correlation = [{ between = ["laser.baseline", "laser.aim"], coefficient = 0.8 }]'
    )
    before, rig = read(tmp_path, stated), read(tmp_path, stated, '[drift]\nbaseline = "0.3 mm"\nprincipal_point = 0.3')
    u = u_of(rig.covariance)
    assert u["laser.baseline"] == pytest.approx(0.5e-3)
    assert u["laser.aim"] == pytest.approx(np.radians(0.1))
    assert u["camera.principal_point_u"] == u["camera.principal_point_v"] == pytest.approx(0.5)
    assert rig.covariance.matrix[0, 1] == pytest.approx(before.covariance.matrix[0, 1])
    assert rig.stripe == 0.2


def test_what_only_drift_names_is_known_by_it_alone_and_the_default_holds_for_what_nobody_names(tmp_path):
    rig = read(tmp_path, '[drift]\nbaseline = "0.3 mm"\naim = "0 deg"')
    assert u_of(rig.covariance) == pytest.approx({"laser.baseline": 3e-4})
    filled = rig.with_default_uncertainty(0.1524)
    assert filled.default_uncertainty
    default = read(tmp_path).with_default_uncertainty(0.1524).covariance
    assert u_of(filled.covariance) == pytest.approx({**u_of(default), "laser.baseline": 3e-4})


def test_no_drift_changes_nothing(tmp_path):
    plain, none = read(tmp_path, CALIBRATION), read(tmp_path, CALIBRATION, '[drift]\nk = 0.0\nbaseline = "0 mm"')
    assert plain.covariance.names == none.covariance.names
    assert np.array_equal(plain.covariance.matrix, none.covariance.matrix)
    assert read(tmp_path, "[drift]").covariance is None


def test_a_rig_is_read_as_it_was_calibrated_where_asked_for(tmp_path):
    plain = read(tmp_path, CALIBRATION)
    text = CALIBRATION, '[drift]\nbaseline = "0.3 mm"\nk = 3.0'
    assert np.array_equal(read(tmp_path, *text, drift=False).covariance.matrix, plain.covariance.matrix)
    assert read_rig_or_camera(tmp_path / "rig.toml", drift=False).covariance.names == plain.covariance.names
    assert read_camera(tmp_path / "rig.toml", drift=False).covariance.u[0] == pytest.approx(0.5)
    assert read_camera(tmp_path / "rig.toml").covariance.u[0] == pytest.approx(np.hypot(0.5, 3.0))


def test_degrees_of_freedom_of_a_sum_follow_welch_and_satterthwaite(tmp_path):
    drift = '[drift]\nbaseline = { u = "0.2 mm", degrees_of_freedom = 6 }\nk = 0.5'
    rig = read(tmp_path, CALIBRATION, drift)
    freedom = dict(zip(rig.covariance.names, rig.covariance.degrees_of_freedom, strict=True))
    # two equal parts: 4 / (1 / 12 + 1 / 6), and 4 / (1 / 30 + 0)
    assert freedom == pytest.approx({"laser.baseline": 16.0, "laser.aim": 12.0, "camera.k": 120.0})
    assert rig.degrees_of_freedom == 76


@pytest.mark.parametrize(("drift", "shape"), [("0.01 mm", "rectangular"), ("0.3 mm", "normal"), ("9 mm", "triangular")])
def test_a_sum_has_the_distribution_of_its_larger_part_or_is_nearly_normal(tmp_path, drift, shape):
    tables = f'[uncertainty]\nbaseline = {{ limits = "0.3 mm" }}\n[drift]\nbaseline = {{ limits = "{drift}", '
    rig = read(tmp_path, tables + 'distribution = "triangular" }')
    assert rig.covariance.distributions == (Distribution(shape),)


def test_drift_of_a_key_counts_for_every_laser(tmp_path):
    two = LASER.replace("[laser]", "[[laser]]")
    path = tmp_path / "rig.toml"
    path.write_text(CAMERA.replace("single", "dual") + two + two + "clock = '2 rad'\n" + '[drift]\naim = "0.1 deg"')
    covariance = read_rig(path).covariance
    assert covariance.names == ("laser.0.aim", "laser.1.aim")
    assert covariance.correlation(*covariance.names) == 0


def test_a_rig_with_drift_that_is_written_is_read_back_as_well_known(tmp_path):
    rig = read(tmp_path, CALIBRATION, '[drift]\nbaseline = "0.3 mm"\nhalf_angle = "0.1 deg"\nk = 2')
    write_rig(rig, tmp_path / "again.toml")
    again = read_rig(tmp_path / "again.toml").covariance
    assert "[drift]" not in (tmp_path / "again.toml").read_text()
    same = again.restricted(rig.covariance.names)
    assert np.allclose(same.matrix, rig.covariance.matrix, rtol=1e-12, atol=0)
    assert same.degrees_of_freedom == pytest.approx(rig.covariance.degrees_of_freedom)


def test_the_drift_of_a_camera_without_a_laser_is_read(tmp_path):
    path = tmp_path / "lens.toml"
    path.write_text(CAMERA.replace('configuration = "single-cone"', "") + "[uncertainty]\nk = 3\n[drift]\nk = 4\n")
    assert read_camera(path).covariance.u == pytest.approx([5.0])
    assert read_camera(path, drift=False).covariance.u == pytest.approx([3.0])


MISTAKES = {
    "[drift]\nbasline = '1 mm'": r"key drift.basline is not known; allowed here: aim, aspect, baseline, c1",
    "[drift]\nbaseline = 0.1": r"key drift.baseline = 0.1 is wrong: 0.1 has no unit",
    "[drift]\nk = -1": r"key drift.k = -1 is wrong.*greater than or equal to 0",
    "[drift]\nstripe = 0.1": r"key drift.stripe is not known",
    "[drift]\ncorrelation = []": r"key drift.correlation is not known",
    "[drift]\nk = { distribution = 'arcsine' }": r"drift.k needs either u .* or limits",
    "[drift]\nport_index = 0.01": r"This rig has no parameter camera.port_index; allowed: laser.baseline",
}


@pytest.mark.parametrize("text", MISTAKES)
def test_a_mistake_in_drift_is_told(tmp_path, text):
    with pytest.raises(InputError, match=MISTAKES[text]):
        read(tmp_path, text)

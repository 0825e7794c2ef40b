"""Where a calibration had points, and cameras without a laser: both survive the rig file."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.optics import Camera, FlatPort, Lens
from calibore.rigs import Laser, Rig, ValidRegion, parts_toml, read_camera, read_rig, read_rig_or_camera, write_rig
from calibore.rigs._valid import TOLERANCE
from calibore.uncertainty import Covariance

CAMERA = Camera(640, 480, Lens("polynomial", 400.0, 240.0, polynomial=(-0.1, 0.01)), (319.0, 241.5), 1.01)
REGION = ValidRegion((0.1, 1.0), (0.1, 0.3))
CALIBRATION = """
[calibration]
parameters = ["camera.k", "target.x"]
covariance = [[0.04, 0.0], [0.0, 1.0]]
degrees_of_freedom = 7.5
kind = "chessboard"
[calibration.valid]
zenith = ["2 deg", "50 deg"]
"""


def written(tmp_path, text):
    path = tmp_path / "my camera.toml"
    path.write_text(text)
    return path


@given(st.floats(0, 2), st.floats(0, 1), st.floats(0.01, 1))
def test_a_region_holds_what_lies_between_its_limits_and_a_little_beyond(zenith, least, width):
    region = ValidRegion(zenith=(least, least + width))
    inside = least <= zenith <= least + width
    outside = not least - 1.01 * TOLERANCE * width <= zenith <= least + width * (1 + 1.01 * TOLERANCE)
    held = bool(region.holds([zenith], [1e6])[0])
    assert held or not inside
    assert not held or not outside


def test_both_limits_count_none_is_no_limit_and_what_was_not_measured_is_not_inside():
    zenith, radius = np.array([0.5, 0.5, 1.5, np.nan]), np.array([0.2, 0.4, 0.2, 0.2])
    assert REGION.holds(zenith, radius).tolist() == [True, False, False, False]
    assert ValidRegion(radius=REGION.radius).holds(zenith, radius).tolist() == [True, False, True, True]
    assert ValidRegion().holds(zenith, radius).all()


def test_a_region_is_said_in_the_unit_asked_for():
    assert REGION.said() == "zenith 5.7 to 57.3 deg, radius 100 to 300 mm"
    assert ValidRegion(radius=(0.1524, 0.3048)).said("in") == "radius 6 to 12 in"
    assert ValidRegion().said() == ""


@pytest.mark.parametrize("limits", [(0.3, 0.1), (0.1, 0.1), (-0.1, 0.1), (0.1, np.inf), (np.nan, 1.0)])
def test_impossible_limits_are_refused(limits):
    with pytest.raises(InputError, match="from a smaller to a larger value"):
        ValidRegion(radius=limits)


@pytest.mark.parametrize("correlated", [True, False])
def test_the_valid_region_of_a_rig_survives_its_file(tmp_path, correlated):
    matrix = [[1e-8, 5e-6 * correlated], [5e-6 * correlated, 0.04]]
    covariance = Covariance(["laser.baseline", "camera.k"], matrix)
    rig = Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.3)),), covariance, valid=REGION)
    write_rig(rig, tmp_path / "rig.toml")
    again = read_rig(tmp_path / "rig.toml")
    assert again.valid == REGION
    assert np.allclose(again.covariance.restricted(covariance.names).matrix, matrix, rtol=1e-12)
    assert again.with_default_uncertainty(0.15).valid == REGION
    write_rig(Rig("perpendicular-plane", CAMERA, rig.lasers, valid=REGION), tmp_path / "bare.toml")
    assert read_rig(tmp_path / "bare.toml").valid == REGION
    assert read_rig(tmp_path / "bare.toml").covariance is None


def test_a_camera_alone_is_written_to_the_last_bit_and_read_back(tmp_path):
    port = FlatPort(3.1e-3, 1.52, 0.1 / 3, 1.33)
    camera = Camera(640, 480, Lens("sine-law", 400 / 3, 240.0, c1=0.01), (319.0, 241.5), pupil_walk=(1e-3,), port=port)
    for one in (CAMERA, camera):
        known = read_camera(written(tmp_path, parts_toml(one)))
        assert known.camera == one
        assert (known.covariance, known.degrees_of_freedom, known.valid) == (None, None, None)


def test_a_camera_brings_what_its_calibration_knows_of_it(tmp_path):
    path = written(tmp_path, parts_toml(CAMERA) + "[uncertainty]\nprincipal_point = 0.5\n" + CALIBRATION)
    known = read_camera(path)
    assert known.covariance.names == ("camera.k", "camera.principal_point_u", "camera.principal_point_v")
    assert np.allclose(known.covariance.matrix, np.diag([0.04, 0.25, 0.25]))
    assert known.degrees_of_freedom == 7.5
    assert known.valid == ValidRegion((np.radians(2), np.radians(50)))
    assert read_rig_or_camera(path).camera == CAMERA


def test_the_camera_of_a_whole_rig_is_known_without_its_laser(tmp_path):
    covariance = Covariance(["laser.baseline", "camera.k"], [[1e-8, 5e-6], [5e-6, 0.04]])
    rig = Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.3)),), covariance, valid=REGION, degrees_of_freedom=9.0)
    write_rig(rig, tmp_path / "rig.toml")
    known = read_camera(tmp_path / "rig.toml")
    assert (known.camera, known.valid, known.degrees_of_freedom) == (CAMERA, REGION, 9.0)
    assert (known.covariance.names, known.covariance.matrix.tolist()) == (("camera.k",), [[0.04]])
    assert isinstance(read_rig_or_camera(tmp_path / "rig.toml"), Rig)
    write_rig(Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.3)),)), tmp_path / "bare.toml")
    assert read_camera(tmp_path / "bare.toml").covariance is None


def test_what_is_missing_for_a_rig_or_a_camera_is_said_with_what_to_do(tmp_path):
    camera, nothing = parts_toml(CAMERA), parts_toml(None)
    with pytest.raises(InputError, match=r"my camera.toml holds a camera without a laser: configuration and \[laser\]"):
        read_rig(written(tmp_path, camera))
    with pytest.raises(InputError, match="Join it with a laser by `calibore calibrate rig`"):
        read_rig(written(tmp_path, camera))
    for read in (read_rig, read_camera):
        with pytest.raises(InputError, match=r"key configuration is missing; add it"):
            read(written(tmp_path, camera + '[laser]\nbaseline = "1 m"\n'))
    with pytest.raises(InputError, match=r"holds no camera: \[camera\] is missing. Give a rig file, or what `calibore"):
        read_camera(written(tmp_path, nothing))
    with pytest.raises(InputError, match="holds no rig"):
        read_rig(written(tmp_path, nothing))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"2 deg"', '"60 deg"', "my camera.toml: The valid zenith goes from a smaller"),
        ('"2 deg"', "2", r"calibration.valid.zenith\[0\] = 2 is wrong: 2 has no unit"),
        ("zenith", "azimuth", "calibration.valid.azimuth is not known; allowed here: radius, zenith"),
        ("camera.k", "camera.zoom", "this camera has no parameter camera.zoom; allowed: camera.k"),
        ("[0.0, 1.0]", "[2.0, 1.0]", "calibration.covariance"),
        ("[camera]", "[uncertainty]\nbaseline = '1 mm'\n[camera]", "uncertainty.baseline is not known"),
    ],
)
def test_a_mistake_in_a_camera_file_is_named(tmp_path, old, new, sentence):
    text = parts_toml(CAMERA) + CALIBRATION
    assert old in text
    with pytest.raises(InputError, match=sentence):
        read_camera(written(tmp_path, text.replace(old, new, 1)))


def test_only_a_calibration_may_name_parameters_that_are_no_rigs(tmp_path):
    covariance = Covariance(["laser.baseline", "camera.k"], [[1e-8, 5e-6], [5e-6, 0.04]])
    write_rig(Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.3)),), covariance), tmp_path / "rig.toml")
    text = (tmp_path / "rig.toml").read_text().replace("camera.k", "target.x")
    with pytest.raises(InputError, match=r"no parameter target\.x"):
        read_rig(written(tmp_path, text))
    text = text.replace("[calibration]", '[calibration]\nkind = "ring-gauge"')
    assert read_rig(written(tmp_path, text)).covariance.names == ("laser.baseline",)

"""rig.toml: what stands in it is read, and every mistake is named with file, key and what is allowed."""

from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.rigs import Laser, Rig, read_rig
from calibore.units import parse_quantity

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
GOOD = """
format = "calibore-rig/1"
configuration = "perpendicular-plane"
[camera]
width = 1024
height = 768
lens = "sine-law"
k = 571.0
principal_point = [512.0, 384.0]
[laser]
baseline = "13.10 in"
channel = "red"
"""
BASELINE = parse_quantity("13.10 in", "length")
UNCERTAINTY = """
[uncertainty]
baseline = "0.006 in"
k = 1.5
principal_point = 0.5
stripe = 1.0
"""
CALIBRATION = """
[calibration]
parameters = ["laser.baseline", "camera.k"]
covariance = [[1e-6, 0.9e-3], [0.9e-3, 1.0]]
degrees_of_freedom = 76
evidence = "calibration.zarr"
"""


def written(tmp_path, text):
    path = tmp_path / "my rig.toml"
    path.write_text(text)
    return path


def test_the_example_of_the_contract_is_read(tmp_path):
    rig = read_rig(written(tmp_path, GOOD + UNCERTAINTY))
    assert rig.configuration == "perpendicular-plane"
    assert rig.lasers == (Laser(Plane(BASELINE), "red"),)
    assert pytest.approx(0.33274) == BASELINE
    assert (rig.camera.width, rig.camera.height, rig.camera.principal_point) == (1024, 768, (512.0, 384.0))
    assert (rig.camera.lens.law, rig.camera.lens.k, rig.camera.lens.half_height) == ("sine-law", 571.0, 384.0)
    assert rig.stripe == 1.0
    assert rig.covariance is not None
    stated = dict(zip(rig.covariance.names, rig.covariance.u, strict=True))
    assert stated == pytest.approx(
        {
            "laser.baseline": 0.006 * 0.0254,
            "camera.k": 1.5,
            "camera.principal_point_u": 0.5,
            "camera.principal_point_v": 0.5,
        }
    )


def test_optional_keys_and_listed_lasers_are_read(tmp_path):
    text = GOOD.replace("[laser]", "[[laser]]\ntakes = [0, 2]\ntilt_x = 0.01\ntilt_y = -2e-3")
    rig = read_rig(written(tmp_path, text.replace("k = 571.0", "k = 571\nc1 = -0.004\nc2 = 0.001\naspect = 1.02")))
    assert (rig.camera.lens.c1, rig.camera.lens.c2, rig.camera.aspect) == (-0.004, 0.001, 1.02)
    assert rig.lasers[0].surface == Plane(BASELINE, 0.01, -0.002)
    assert [rig.lasers[0].is_lit(take) for take in range(3)] == [True, False, True]


def test_a_channel_that_is_not_stated_is_left_to_the_reader_of_the_images(tmp_path):
    assert read_rig(written(tmp_path, GOOD.replace('channel = "red"', ""))).lasers[0].channel is None


def test_a_calibration_brings_its_full_covariance_and_independent_inputs_join_it(tmp_path):
    rig = read_rig(written(tmp_path, GOOD + CALIBRATION + "[uncertainty]\ntilt_x = 0.002\n"))
    assert rig.covariance is not None
    assert rig.covariance.names == ("laser.baseline", "camera.k", "laser.tilt_x")
    assert np.allclose(rig.covariance.matrix, [[1e-6, 0.9e-3, 0], [0.9e-3, 1, 0], [0, 0, 4e-6]])
    assert rig.degrees_of_freedom == 76
    assert rig.with_default_uncertainty(0.15) is rig


def test_without_stated_uncertainty_the_default_comes_from_the_nominal_radius(tmp_path):
    rig = read_rig(written(tmp_path, GOOD))
    assert rig.covariance is None
    assert not rig.default_uncertainty
    filled = rig.with_default_uncertainty(0.1524)
    assert filled.default_uncertainty
    assert filled.covariance is not None
    assert filled.covariance.names == ("laser.baseline",)
    assert filled.covariance.u[0] == pytest.approx(0.0001524 / np.sqrt(3))
    with pytest.raises(InputError, match=r"nominal radius must be positive, got -0.1 m"):
        rig.with_default_uncertainty(-0.1)


def test_a_baseline_of_unstated_uncertainty_gets_the_default_beside_what_is_stated(tmp_path):
    filled = read_rig(written(tmp_path, GOOD + "[uncertainty]\nk = 2\n")).with_default_uncertainty(0.15)
    assert filled.covariance is not None
    assert filled.covariance.names == ("camera.k", "laser.baseline")
    exact = read_rig(written(tmp_path, GOOD + '[uncertainty]\nbaseline = "0 mm"\n')).with_default_uncertainty(0.15)
    assert not exact.default_uncertainty


MISTAKES = {
    "unknown lens": (("sine-law", "fisheye"), "camera.lens", "'equisolid-angle' or 'polynomial'"),
    "unknown configuration": (("perpendicular-plane", "corkscrew"), "configuration", "allowed: perpendicular-plane"),
    "a cone without angles": (("perpendicular-plane", "single-cone"), "laser.aim is missing", "add it"),
    "one laser for two": (("perpendicular-plane", "dual-cone"), "laser", "a list"),
    "a head without aim": (("perpendicular-plane", "side-facing"), "laser.aim is missing", "add it"),
    "a coaxial cone beside the axis": (
        ("perpendicular-plane", "coaxial-cone"),
        "laser.half_angle is missing",
        "add it",
    ),
    "limits of nothing": (("", "[uncertainty]\nk = { distribution = 'arcsine' }"), "uncertainty.k", "either u"),
    "limits of a normal": (
        ("", "[uncertainty]\nk = { limits = 1.0, distribution = 'normal' }"),
        "uncertainty.k",
        "which has none",
    ),
    "another distribution": (
        ("", "[uncertainty]\nk = { u = 1.0, distribution = 'flat' }"),
        "distribution",
        "'arcsine'",
    ),
    "impossible coefficient": (
        ("", UNCERTAINTY + "correlation = [{ between = ['laser.baseline', 'camera.k'], coefficient = 1.5 }]"),
        "coefficient",
        "less than or equal to 1",
    ),
    "correlation with what is not stated": (
        ("", UNCERTAINTY + "correlation = [{ between = ['laser.baseline', 'camera.c1'], coefficient = 0.5 }]"),
        "camera.c1",
        "laser.baseline",
    ),
    "unknown channel": (('"red"', '"infrared"'), "laser.channel", "'green', 'blue' or 'luma'"),
    "missing key": (("k = 571.0\n", ""), "camera.k is missing", "add it"),
    "missing laser": (('[laser]\nbaseline = "13.10 in"\nchannel = "red"', ""), "laser is missing", "add it"),
    "missing camera table": (("[camera]", "[lens]"), "camera is missing", "add it"),
    "unknown key": (("k = 571.0", "k = 571.0\nzoom = 2"), "camera.zoom is not known", "principal_point"),
    "unknown laser key": (('"red"', '"red"\naim = "3 deg"'), "laser.aim is not known", "tilt_x"),
    "other format": (("calibore-rig/1", "calibore-rig/2"), "format", "'calibore-rig/1'"),
    "wrong unit": (('"13.10 in"', '"13.10 kg"'), "laser.baseline", "a length such as"),
    "no unit": (('"13.10 in"', "13.1"), "laser.baseline", 'e.g. "13.1 mm"'),
    "unit in a pure number": (("571.0", '"571 px"'), "camera.k", "a number without quotes"),
    "negative baseline": (('"13.10 in"', '"-13.10 in"'), "laser.baseline", "greater than 0"),
    "negative k": (("571.0", "-571.0"), "camera.k", "greater than 0"),
    "NaN": (("[512.0, 384.0]", "[nan, 384.0]"), "camera.principal_point[0]", "finite"),
    "NaN with unit": (('"13.10 in"', '"nan in"'), "laser.baseline", "finite"),
    "infinity": (("571.0", "inf"), "camera.k", "finite"),
    "one coordinate": (("[512.0, 384.0]", "[512.0]"), "camera.principal_point[1]", "missing"),
    "half a pixel": (("1024", "1024.5"), "camera.width", "a whole number"),
    "no pixels": (("1024", "0"), "camera.width", "greater than 0"),
    "true for a number": (("571.0", "true"), "camera.k", "a number without quotes"),
    "polynomial without coefficients": (("sine-law", "polynomial"), "[p3, p5, ...]", "polynomial"),
    "no takes": (('"red"', '"red"\ntakes = []'), "laser.takes", "at least 1"),
    "two planes": (("[laser]", '[[laser]]\nbaseline = "1 in"\n[[laser]]'), "laser", "at most 1"),
    "broken TOML": (("k = 571.0", "k = "), "not valid TOML", "Correct that line"),
    "negative uncertainty": (("", "[uncertainty]\nk = -1"), "uncertainty.k", "greater than or equal to 0"),
    "unknown uncertainty": (
        ("", "[uncertainty]\nlens = 1"),
        "uncertainty.lens is not known",
        "principal_point, pupil_walk, stripe",
    ),
    "unit of uncertainty": (("", '[uncertainty]\nbaseline = "1 deg"'), "uncertainty.baseline", "a length such as"),
    "unknown parameter": (
        ("", CALIBRATION.replace("camera.k", "camera.zoom")),
        "camera.zoom",
        "allowed: laser.baseline",
    ),
    "not square": (("", CALIBRATION.replace(", [0.9e-3, 1.0]", "")), "calibration.covariance", r"shape (2, 2)"),
    "ragged": (("", CALIBRATION.replace("[0.9e-3, 1.0]", "[0.9e-3]")), "calibration.covariance", "2 numbers"),
    "not symmetric": (("", CALIBRATION.replace("0.9e-3]", "0.5e-3]")), "calibration.covariance", "symmetric"),
    "impossible correlation": (
        ("", CALIBRATION.replace("0.9e-3", "1.9e-3")),
        "calibration.covariance",
        "semi-definite",
    ),
    "stated twice": (("", CALIBRATION + UNCERTAINTY), "laser.baseline", "keep one of them"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_file_key_and_what_is_allowed(tmp_path, mistake):
    (old, new), key, allowed = MISTAKES[mistake]
    text = GOOD.replace(old, new, 1) if old else GOOD + new
    assert text != GOOD
    with pytest.raises(InputError) as caught:
        read_rig(written(tmp_path, text))
    sentence = str(caught.value)
    assert "my rig.toml" in sentence
    assert key in sentence
    assert allowed in sentence
    assert "\n" not in sentence


def test_a_missing_or_unreadable_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nowhere.toml does not exist"):
        read_rig(tmp_path / "nowhere.toml")
    with pytest.raises(InputError, match="cannot be read"):
        read_rig(tmp_path)


def test_every_rig_of_the_shared_data_is_read():
    if not SIMULATED.is_dir():
        pytest.skip(f"{SIMULATED} is absent: its rig files are not read")
    found = {read_rig(path).configuration for path in sorted(SIMULATED.glob("**/rig.toml"))}
    assert {"perpendicular-plane", "single-cone", "dual-cone", "side-facing"} <= found


def test_a_rig_built_by_hand_is_checked_too(tmp_path):
    rig = read_rig(written(tmp_path, GOOD))
    with pytest.raises(InputError, match="at least one laser"):
        Rig("perpendicular-plane", rig.camera, ())
    with pytest.raises(InputError, match="allowed: red, green, blue, luma"):
        Laser(Plane(1.0), "violet")
    with pytest.raises(InputError, match=r"must not be negative, got -1\.0 px"):
        Rig("perpendicular-plane", rig.camera, rig.lasers, stripe=-1.0)

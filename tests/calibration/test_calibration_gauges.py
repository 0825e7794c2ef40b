"""Planes and cones of light from ring gauges and flats: the truth is where the calibration says, and no further."""

import numpy as np
import pytest
from calibration_rig_cases import CAMERA, COAXIAL, CONE, PLANE, designed, looks_at_gauges
from known_marks import flat_ahead_look, gauge_look

from calibore.calibration import calibrate_gauges
from calibore.calibration._outlines import annulus
from calibore.calibration._rig._gauges import fit_gauges
from calibore.calibration._rig._gauges_findings import radius_uncertainty
from calibore.calibration._rig._references import AHEAD, FlatTarget, RingGauge
from calibore.calibration._rig._stops import without_wrong_stops
from calibore.errors import InputError
from calibore.fitting import region_contains
from calibore.geometry import Pose
from calibore.lasers import Cone, Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, moved, value_of, values_of, write_rig
from calibore.simulation import PipeWall, Sensor, render_ring
from calibore.simulation._files import write_png
from calibore.uncertainty import Covariance


def away(found, true):
    """Errors of the parameters found in standard uncertainties."""
    truth, u = values_of(true, found.free), found.covariance.u
    return np.array([(value_of(found.rig, name) - truth[name]) for name in found.free]) / u


@pytest.mark.parametrize(("true", "free"), [(PLANE, 3), (CONE, 5), (COAXIAL, 2)], ids=["plane", "cone", "coaxial"])
def test_regions_hold_the_truth_as_often_as_they_say(true, free):
    """Over 200 random rigs: 95 % of planes, 94 % of cones; here 2, both of which miss in 1 of 400."""
    held, z = 0, []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        found, choice = fit_gauges(designed(true, rng), looks_at_gauges(true, rng, marks=160))
        assert len(found.free) == free
        assert not choice.held
        truth = np.array([value_of(true, name) - value_of(found.model.rig, name) for name in found.free])
        held += region_contains(found.fit, truth, names=found.free)
        z.extend(away(found, true))
    assert held >= 1
    assert 0.25 < np.median(np.abs(z)) < 1.7


def test_one_gauge_does_not_tell_half_angle_and_offset_of_a_coaxial_cone_apart():
    rng = np.random.default_rng(4)
    looks = looks_at_gauges(COAXIAL, rng, sizes=(0.24,))
    found, choice = fit_gauges(designed(COAXIAL, rng), looks)
    assert found.free == ("laser.half_angle",)
    assert choice.held == ("laser.offset",)


def test_what_a_rig_file_states_counts_where_gauges_do_not_tell():
    rng = np.random.default_rng(5)
    stated = Covariance.independent({"laser.offset": 5e-4, "laser.half_angle": 1e-9})
    looks = looks_at_gauges(COAXIAL, rng, sizes=(0.24,))
    found, choice = fit_gauges(designed(COAXIAL, rng), looks, design=stated)
    assert choice.stated == ("laser.offset",)
    assert not choice.held
    assert found.change("laser.offset")[1] == pytest.approx(5e-4, rel=0.1)
    assert (
        np.abs(away(found, COAXIAL)).max() < 3.5
    )  # a half angle stated far too well does not pull: the gauge tells it


def test_an_uncertain_lens_makes_the_baseline_uncertain_but_hardly_the_radius():
    rng = np.random.default_rng(6)
    looks = looks_at_gauges(PLANE, rng)
    lens = Covariance.independent({"camera.k": 2e-3 * 420.0})
    exact, _ = fit_gauges(PLANE, looks)
    known, _ = fit_gauges(PLANE, looks, camera=lens)
    assert "camera.k" in known.free
    assert known.change("laser.baseline")[1] > 10 * exact.change("laser.baseline")[1]
    assert radius_uncertainty(known)[0].max() < 2 * radius_uncertainty(exact)[0].max()


def test_flats_at_stand_offs_tell_a_cone_as_gauges_do():
    rng = np.random.default_rng(7)
    looks = [
        flat_ahead_look(
            CONE,
            stand_off,
            rng,
            name=f"flat {number}",
            slope=tuple(0.005 * rng.standard_normal(2)),
            u_tilt=0.005,
            off=1e-5 * rng.standard_normal(),
            marks=64,
        )
        for number, stand_off in enumerate((0.13, 0.16, 0.2, 0.24))
    ]
    found, _ = fit_gauges(designed(CONE, rng), looks)
    assert {"laser.baseline", "laser.aim", "laser.half_angle"} <= set(found.free)
    assert np.abs(away(found, CONE)).max() < 3.5


def test_a_gauge_that_is_not_what_it_says_is_named_with_its_amount():
    rng = np.random.default_rng(8)
    sizes = (0.20, 0.22, 0.24, 0.25, 0.26, 0.28)
    looks = looks_at_gauges(PLANE, rng, sizes=sizes, wrong={3: 4e-4}, marks=40)
    found, _ = fit_gauges(designed(PLANE, rng), looks)
    found, wrong = without_wrong_stops(found, fewest=2)
    assert [one.stop for one in wrong] == [looks[3].name]
    assert wrong[0].off == pytest.approx(4e-4, rel=0.3)
    assert np.abs(away(found, PLANE)).max() < 3.5


SMALL = Camera(360, 280, Lens("equidistant", 150.0, 140.0), (180.0, 140.0))
QUIET = Sensor(speckle_contrast=0.2)
HEADING = 'format = "calibore-target/1"\nkind = "ring-gauge"\nrig = "design.toml"\n'


def photographed(folder, true, design, gauges, *, takes=1, more=""):
    """The folder of a calibration: pictures, design.toml, target.toml."""
    rng, text = np.random.default_rng(20), HEADING + more
    for number, (size, centre) in enumerate(gauges):
        pose = Pose.from_roll_pitch_yaw(0.0, *(0.006 * rng.standard_normal(2)), translation=(*centre, 0.0))
        for take in range(takes):
            picture = render_ring(true, PipeWall(size / 2), pipe_from_rig=pose, rng=rng, sensor=QUIET)
            write_png(folder / f"g{number} {take}.png", picture)
        images = f"g{number} {{take}}.png" if takes > 1 else f"g{number} 0.png"
        text += f'[[look]]\nimages = "{images}"\ngauge = "{1e3 * size:g} mm"\nu = "0.02 mm"\n'
    write_rig(design, folder / "design.toml")
    (folder / "target.toml").write_text(text)
    return folder


def test_rendered_pictures_of_a_plane_in_gauges_give_it_back(tmp_path):
    true = Rig("perpendicular-plane", SMALL, (Laser(Plane(0.12, 0.01, -0.006), "red"),))
    design = moved(true, {"laser.baseline": 0.004, "laser.tilt_x": -0.01, "laser.tilt_y": 0.006})
    gauges = [(0.16, (0.004, 0.002)), (0.2, (-0.012, 0.008)), (0.24, (0.012, -0.006))]
    found = calibrate_gauges(photographed(tmp_path, true, design, gauges, takes=2))
    truth = values_of(true, found.values)
    for name, u in zip(found.covariance.names, found.covariance.u, strict=True):
        assert abs(found.values[name] - truth[name]) < 3.2 * u, name
    assert found.values["laser.baseline"] == pytest.approx(0.12, abs=2e-4)
    assert len(found.files) == 6
    assert not any(file.refused for file in found.files)
    assert any("k of the lens is taken as exact" in warning for warning in found.warnings)
    assert any(sentence.startswith("Baseline: found 1") and "stated 124" in sentence for sentence in found.findings)
    assert found.valid.radius[0] < 0.08 < 0.12 < found.valid.radius[1]
    assert found.valid.zenith[0] == 0.0 < found.valid.zenith[1]


def test_rendered_pictures_of_a_cone_in_gauges_give_it_back(tmp_path):
    true = Rig("single-cone", SMALL, (Laser(Cone.for_ring(0.04, 0.13, 0.1), "red"),))
    design = moved(true, {"laser.baseline": 0.001, "laser.aim": 0.006, "laser.half_angle": -0.005})
    gauges = [(0.17, (0.004, 0.002)), (0.2, (-0.006, 0.008)), (0.24, (0.01, -0.004))]
    found = calibrate_gauges(photographed(tmp_path, true, design, gauges))
    truth = values_of(true, found.values)
    z = [(found.values[name] - truth[name]) / u for name, u in zip(found.values, found.covariance.u, strict=True)]
    assert np.abs(z).max() < 3.2


@pytest.mark.parametrize("clock", [0.0, 2.0])
def test_a_line_is_looked_for_where_it_is(clock):
    rng = np.random.default_rng(9)
    rig = Rig("single-cone", CAMERA, (Laser(Cone.for_ring(0.05, 0.18, 0.12, clock=clock), "red"),))
    for reference, look in (
        (FlatTarget(0.18, AHEAD), flat_ahead_look(rig, 0.18, rng, name="flat", slope=(0.01, -0.01))),
        (RingGauge(0.24), gauge_look(rig, 0.24, rng, name="gauge", centre=(0.01, -0.01))),
    ):
        where = annulus(designed(rig, rng), reference, laser=0)
        distance = np.hypot(look.u - where.centre[0], look.v - where.centre[1])
        assert where.inner < distance.min()
        assert distance.max() < where.outer


def test_a_target_that_cannot_be_used_says_why(tmp_path):
    design = Rig("perpendicular-plane", SMALL, (Laser(Plane(0.12), "red"),))
    folder = photographed(tmp_path, design, design, [(0.2, (0.0, 0.0))])
    whole = (folder / "target.toml").read_text()

    def refused(text, match):
        (folder / "target.toml").write_text(text)
        with pytest.raises(InputError, match=match):
            calibrate_gauges(folder)

    refused(whole.replace("gauge =", "flat ="), "parallel to a plane of light.*use ring gauges")
    refused(whole.replace('gauge = "200 mm"\n', ""), "needs gauge .* or flat")
    refused(whole.replace("g0 0.png", "g7.png"), r'no picture "g7.png"')
    refused(whole.replace('u = "0.02 mm"\n', ""), r"key look\[0\].u is missing")
    elsewhere = "lies in the light of the laser|The rig was looked for near what its file says|No picture shows"
    refused(whole.replace("200 mm", "2 m"), elsewhere)
    write_png(folder / "g0 0.png", np.full((280, 360, 3), 4, dtype=np.uint8))
    refused(whole, "No picture shows the laser's line where the rig file expects it .*check exposure")
    write_png(folder / "g0 0.png", np.full((28, 36, 3), 4, dtype=np.uint8))
    refused(whole, r'"g0 0.png" is 36 x 28 px, the rig.s camera 360 x 280 px')


def test_each_of_two_cones_needs_pictures_of_its_own(tmp_path):
    lasers = tuple(Laser(Cone.for_ring(0.04, 0.13, 0.1, clock=clock), "red") for clock in (0.0, np.pi))
    design = Rig("dual-cone", SMALL, lasers)
    single = Rig("single-cone", SMALL, lasers[:1])
    folder = photographed(tmp_path, single, design, [(0.2, (0.0, 0.0))])
    with pytest.raises(InputError, match=r"shows laser 0 alone; photograph every laser by itself.*takes = \[1\]"):
        calibrate_gauges(folder)


def test_one_gauge_is_warned_of(tmp_path):
    true = Rig("perpendicular-plane", SMALL, (Laser(Plane(0.12), "red"),))
    found = calibrate_gauges(photographed(tmp_path, true, moved(true, {"laser.baseline": 1e-3}), [(0.2, (0.0, 0.0))]))
    assert any("There is one reference only" in warning for warning in found.warnings)
    assert found.values["laser.baseline"] == pytest.approx(0.12, abs=1e-4)

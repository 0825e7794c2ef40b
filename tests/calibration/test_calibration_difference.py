"""Is this the same camera as last year: answered by chance where it is, by name where it is not."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_calibrations import (
    RADIUS,
    board_calibration,
    cone_rig,
    drawn,
    fisheye,
    known,
    plane_rig,
    published_head,
    rig_calibration,
)
from scipy.stats import kstest

from calibore.calibration import difference
from calibore.calibration._difference._directions import turn_between
from calibore.calibration._difference._test import Evidence, judged
from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.rigs import KnownCamera, ValidRegion, moved
from calibore.uncertainty import Covariance

PAIRS = 100
UNLIKELY = 0.001
"""Kolmogorov-Smirnov: a uniform p fails one seed in a thousand; the seed is fixed."""
RIGS = {"plane": known(plane_rig(), size=0.5), "cone": known(cone_rig(), size=0.1), "head": published_head()}


@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS)
def test_a_calibration_does_not_differ_from_itself(rig):
    found = difference(rig, rig, nominal_radius=RADIUS)
    assert found.p == 1.0
    assert found.directions.rms < 1e-9
    assert np.nanmax(np.abs(found.wall.difference)) < 1e-12
    assert "Nothing speaks against" in found.verdict()
    assert all(one.change == 0 for one in found.changes)


@pytest.fixture(scope="module", params=RIGS)
def by_chance(request):
    """Differences of 100 pairs of calibrations, drawn from one covariance."""
    rig, rng, radii = RIGS[request.param], np.random.default_rng(11), np.array([0.92, 1.0, 1.08]) * RADIUS
    rig = replace(rig, degrees_of_freedom=None)
    pairs = (drawn(rig, rng, 2) for _ in range(PAIRS))
    return [difference(*pair, nominal_radius=RADIUS, radii=radii) for pair in pairs]


def test_two_calibrations_of_one_rig_differ_by_chance_alone(by_chance):
    p = [(one.p, one.directions.judgement.p, one.wall.judgement.p) for one in by_chance]
    for values in np.transpose(p):
        assert kstest(values, "uniform").pvalue > UNLIKELY


def test_what_is_expected_is_what_chance_does(by_chance):
    """Root mean squares in the image and on the wall, and the 95 % band of the mean radius."""
    rms = np.array([(one.directions.rms, one.wall.rms[1]) for one in by_chance])
    expected = np.array([(one.directions.expected, one.wall.expected[1]) for one in by_chance])
    np.testing.assert_allclose(np.sqrt((rms**2).mean(0) / (expected**2).mean(0)), 1, atol=0.15)  # 1 / sqrt(400) x 3
    inside = [abs(one.wall.mean[1]) <= one.wall.coverage * one.wall.u_mean[1] for one in by_chance]
    assert 0.90 <= np.mean(inside) <= 0.99  # 95 % of 200, three standard deviations


def test_few_degrees_of_freedom_are_believed_less():
    """A scatter estimated with 6 degrees of freedom each: p by the F distribution stays uniform."""
    rng, freedom = np.random.default_rng(4), 6
    shape = rng.normal(size=(30, 3))
    p = []
    for _ in range(PAIRS):
        scale = np.sqrt(rng.chisquare(freedom, 2) / freedom)
        moved_by = shape @ (rng.normal(size=3) + rng.normal(size=3))
        evidence = Evidence(moved_by, moved_by, scale[0] * shape, scale[1] * shape, (freedom, freedom))
        p.append((judged(evidence).p, judged(evidence._replace(degrees_of_freedom=(np.inf, np.inf))).p))
    honest, naive = np.transpose(p)
    assert kstest(honest, "uniform").pvalue > UNLIKELY
    assert (naive < 0.05).mean() > 1.5 * (honest < 0.05).mean()


def test_a_camera_turned_in_its_mount_is_the_same_camera():
    """Aimed 1 deg elsewhere: no direction differs, but on the wall everything does."""
    rig = published_head()
    turned = moved(rig, {"laser.aim": np.radians(1.0)})
    found = difference(rig, turned, nominal_radius=RADIUS)
    assert found.directions.rms < 1e-9
    assert found.directions.judgement.p == pytest.approx(1.0)
    assert np.nanmax(np.abs(found.wall.mean)) > 1e-3
    assert found.p < 1e-6
    assert found.changes[0].name == "laser.aim"


@pytest.mark.parametrize("degrees", [1.0, 40.0])
def test_the_turn_between_two_sets_of_directions_is_found_exactly(degrees):
    camera = fisheye()
    rng = np.random.default_rng(2)
    directions = camera.unproject(rng.uniform(0, 1023, 200), rng.uniform(0, 767, 200)).direction
    turn = Pose.from_roll_pitch_yaw(np.radians(degrees), np.radians(-degrees), np.radians(degrees / 2)).rotation
    found = turn_between(directions, directions @ turn.T, rng.uniform(0.5, 2.0, 200))
    np.testing.assert_allclose(found, turn, atol=1e-12)


def test_a_shifted_tele_lens_is_called_a_turned_camera():
    """1 px of principal point of a tele lens is a turn by 1/9000 rad, and nearly nothing else."""
    lens = Lens("perspective", 9000.0, 384.0)
    covariance = Covariance.independent({"camera.k": 0.5, "camera.principal_point_u": 3.0})
    a, b = (KnownCamera(Camera(1024, 768, lens, (u, 384.0)), covariance) for u in (512.0, 513.0))
    found = difference(a, b)
    assert found.directions.rms < 0.01
    assert np.abs(found.directions.turn[1]) == pytest.approx(1 / 9000, rel=0.02)


def test_a_changed_lens_is_found_and_named():
    """Table 8.1: k changed by 2.58 %."""
    rig = published_head()
    changed = moved(rig, {"camera.k": 0.0258 * rig.camera.lens.k})
    found = difference(rig, changed, nominal_radius=RADIUS)
    assert found.p < 1e-6
    first = found.changes[0]
    assert first.name == "camera.k"
    assert first.share == pytest.approx(1.0, abs=1e-6)
    assert first.relative == pytest.approx(0.0258)
    assert abs(first.sigmas) < 2  # alone it would not stand out: it is known to 1.5 % only, but not on its own
    words = found.verdict("in")
    assert "not the same camera" in words
    assert "k alone" in words
    assert "+2.58 %" in words
    assert "6 in" in words


@pytest.mark.parametrize("unit", ["mm", "in"])
@pytest.mark.parametrize("change", [{}, {"laser.baseline": 1e-7}, {"laser.baseline": 0.04}, {"camera.k": 1e-5}])
def test_the_verdict_is_written_as_people_write_numbers(change, unit):
    rig = known(plane_rig())
    words = difference(rig, moved(rig, change), nominal_radius=RADIUS).verdict(unit)
    assert not re.search(r"\d[eE][-+]?\d|nan|inf", words)
    assert f"R = {'152.4 mm' if unit == 'mm' else '6 in'} " in words
    assert ("by 0 px rms" in words) == ("camera.k" not in change)


def test_one_direction_is_one():
    only_k = plane_rig().knowing(Covariance.independent({"camera.k": 0.1}))
    assert "in 1 direction)" in difference(only_k, only_k, nominal_radius=RADIUS).verdict()


def test_what_every_ring_takes_up_as_its_centre_is_no_difference_on_the_wall():
    rig = known(plane_rig())
    tilted = moved(rig, {"laser.tilt_x": 1e-4})
    found = difference(rig, tilted, nominal_radius=RADIUS, radii=[RADIUS])
    assert np.abs(found.wall.shift).max() > 5e-6  # R^2 / D x tilt
    assert np.nanmax(np.abs(found.wall.difference)) < 0.02 * np.abs(found.wall.shift).max()


def test_lenses_of_different_laws_are_compared_by_where_they_see_what():
    a, b = board_calibration(1), board_calibration(2, fitted="equisolid-angle")
    found = difference(a, b)
    assert not found.same_law
    assert found.directions.rms < 4 * found.directions.expected
    assert {one.name for one in found.changes} == {"camera.principal_point_u", "camera.principal_point_v"}
    wrong = difference(a, board_calibration(3, law="perspective", fitted="perspective"))
    assert wrong.directions.rms > 20
    assert "not the same camera" in wrong.verdict()


def test_independent_calibrations_of_one_camera_agree():
    found = difference(board_calibration(1), board_calibration(2))
    assert found.p > 0.01
    assert found.wall is None
    other = difference(rig_calibration(1), rig_calibration(2), nominal_radius=RADIUS)
    assert other.p > 0.01
    assert other.wall.radius.min() >= 0.7 * RADIUS - 1e-12  # where both had points


def test_a_rig_and_a_camera_file_are_compared_by_their_cameras():
    rig = known(plane_rig())
    covariance = rig.covariance.restricted(rig.camera.parameter_names)
    other = KnownCamera(replace(rig.camera, lens=replace(rig.camera.lens, k=rig.camera.lens.k + 40)), covariance)
    found = difference(rig, other)
    assert found.wall is None
    assert found.changes[0].name == "camera.k"
    assert found.p < 0.01


def test_a_calibration_down_to_the_axis_is_compared_off_it():
    rig = replace(known(plane_rig()), valid=ValidRegion(radius=(0.0, 1.2 * RADIUS)))
    found = difference(rig, rig, nominal_radius=RADIUS)
    assert found.wall.radius.min() > 0
    assert found.p == 1.0


def test_without_any_stated_uncertainty_there_is_no_verdict():
    a, b = (KnownCamera(fisheye(c1=c1)) for c1 in (-0.02, -0.03))
    found = difference(a, b)
    assert np.isnan(found.p)
    assert "Neither calibration states its uncertainty" in found.verdict()
    assert difference(a, a).p == 1.0


@pytest.mark.parametrize(
    ("second", "words"),
    [
        (KnownCamera(replace(fisheye(), width=800)), "differ in size"),
        (KnownCamera(fisheye(), valid=ValidRegion(zenith=(1.3, 1.4))), "do not overlap"),
    ],
)
def test_what_cannot_be_compared_is_refused(second, words):
    first = KnownCamera(fisheye(), valid=ValidRegion(zenith=(0.0, 1.0)))
    with pytest.raises(InputError, match=words):
        difference(first, second)


def test_rigs_are_compared_on_a_wall_that_somebody_names():
    rig = known(plane_rig())
    with pytest.raises(InputError, match="nominal radius"):
        difference(rig, rig)
    tele = known(plane_rig(Camera(1024, 768, Lens("equidistant", 2000.0, 384.0), (512.0, 384.0))))
    with pytest.raises(InputError, match="no common wall"):
        difference(tele, tele, nominal_radius=RADIUS)

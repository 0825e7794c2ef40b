"""Several lasers: which take shows which, and what a take that shows none alone means."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.images import StationImages
from calibore.lasers import Cone
from calibore.optics import Camera, Lens
from calibore.profiling import Job, measure_station, prepare
from calibore.profiling._lasers import alone_in, check_told_apart
from calibore.profiling._missing import unlit_sentence
from calibore.profiling._placement import Placement
from calibore.profiling._rig_table import describe_rig
from calibore.profiling._search import search_region
from calibore.profiling._station import StationRefusedError
from calibore.rigs import Laser, Rig, project_ring
from calibore.scans import read_scan
from calibore.simulation import PipeWall, Sensor, render_ring
from calibore.status import Status

RADIUS = 0.15
HERE = Placement(1.0)


def rig(*takes, channels=("red", "red")):
    camera = Camera(400, 300, Lens("sine-law", 215.0, 150.0), (200.0, 150.0))
    cones = [Cone.for_ring(0.075, 0.3, RADIUS, clock=clock) for clock in (0.0, np.pi / 2)]
    given = zip(cones, channels, takes, strict=True)
    return Rig("dual-cone", camera, tuple(Laser(cone, channel, lit) for cone, channel, lit in given))


@pytest.fixture(scope="module")
def pictures():
    """Take 0 with both lines, takes 1 and 2 with one each."""
    pose, rng = Pose.from_roll_pitch_yaw(0.0, 0.0, 0.0, translation=(0.0, 0.0, 0.0)), np.random.default_rng(1)
    wall, sensor = PipeWall(RADIUS), Sensor(speckle_contrast=0.2)
    here = rig((1,), (2,))
    single = [render_ring(here, wall, pipe_from_rig=pose, rng=rng, sensor=sensor, laser=n) for n in (0, 1)]
    return np.maximum(*single), *single


def station(pictures):
    names = tuple(f"cone 0 {take}.png" for take in range(len(pictures)))
    return StationImages(0, tuple(range(len(pictures))), lambda take: pictures[take], names=names)


def test_two_lasers_make_one_ring_without_a_gap_and_the_take_with_both_is_left_alone(pictures):
    result = measure_station(station(pictures), HERE, Job.of(rig((1,), (2,)), RADIUS))
    assert (result.unlit, result.refused, result.images) == ((0,), (), 2)
    assert np.isfinite(result.profile.radius).all()
    assert np.isnan(result.take_correlation)
    assert {line.laser for line in result.lines} == {0, 1}
    assert set(result.points.take) == {1, 2}
    u = np.hypot(result.profile.u_independent, result.profile.u_common)
    assert np.mean(np.abs(result.profile.radius - RADIUS) <= 1.96 * u) > 0.93


def test_each_laser_is_uncertain_where_the_other_is_not(pictures):
    both = measure_station(station(pictures), HERE, Job.of(rig((1,), (2,)), RADIUS)).profile
    for number, take in ((0, 1), (1, 2)):
        one = measure_station(station(pictures[take : take + 1]), HERE, Job.of(alone(number), RADIUS)).profile
        missing = np.isnan(one.radius)
        assert 0.005 < missing.mean() < 0.15
        assert (one.status[missing] == Status.GRAZING).mean() > 0.9
        seen = ~missing
        size = np.hypot(one.u_independent, one.u_common)[seen]
        assert (np.hypot(both.u_independent, both.u_common)[seen] <= size * (1 + 1e-9)).mean() > 0.97


def alone(number):
    whole = rig(None, None)
    return replace(whole, configuration="single-cone", lasers=whole.lasers[number : number + 1])


def test_the_missing_laser_leaves_the_ring_of_the_other(pictures):
    result = measure_station(station([pictures[0], pictures[1]]), HERE, Job.of(rig((1,), (2,)), RADIUS))
    single = measure_station(station([pictures[1]]), HERE, Job.of(alone(0), RADIUS))
    np.testing.assert_allclose(result.profile.radius, single.profile.radius, rtol=1e-12)


def test_a_station_in_which_no_laser_is_alone_is_refused_with_the_remedy(pictures):
    with pytest.raises(StationRefusedError, match=r"laser\.takes .* correct one of them"):
        measure_station(station(pictures[:1]), HERE, Job.of(rig((1,), (2,)), RADIUS))


@pytest.mark.parametrize("takes", [(None, None), ((1,), (1,)), ((0, 1), None), ((1,), (0, 1))])
def test_lines_of_one_colour_that_are_never_alone_are_an_error_that_names_the_key(takes):
    job = Job.of(rig(*takes), RADIUS)
    with pytest.raises(InputError, match=r"cannot be told apart\. Set laser\.takes"):
        check_told_apart(job.rig, job.looks)


@pytest.mark.parametrize(
    ("takes", "channels", "expected"),
    [
        (((1,), (2,)), ("red", "red"), [[], [0], [1]]),
        ((None, (2,)), ("red", "green"), [[0], [0], [0, 1]]),
        (((0, 1), (1, 2)), ("red", "red"), [[0], [], [1]]),
        ((None, None), ("red", "green"), [[0, 1], [0, 1], [0, 1]]),
    ],
)
def test_a_take_shows_the_lasers_that_are_lit_in_it_and_alone_in_their_colour(takes, channels, expected):
    job = Job.of(rig(*takes, channels=channels), RADIUS)
    check_told_apart(job.rig, job.looks)
    assert [[look.laser for look in alone_in(take, job.rig, job.looks)] for take in range(3)] == expected


def test_lines_of_two_colours_in_one_picture_are_measured_both(pictures):
    colours = np.zeros_like(pictures[0])
    colours[..., 0], colours[..., 1] = pictures[1][..., 0], pictures[2][..., 0]
    result = measure_station(station([colours]), HERE, Job.of(rig(None, None, channels=("red", "green")), RADIUS))
    assert (result.images, result.row["takes"], len(result.lines)) == (1, 1, 2)
    # where the lines run into each other neither has its own colour: left out, not mixed
    assert np.isfinite(result.profile.radius).mean() > 0.8
    assert np.nanmax(np.abs(result.profile.radius - RADIUS)) < 0.05 * RADIUS


SIDE = """format = "calibore-rig/1"
configuration = "side-facing"
[camera]
width = 400
height = 300
lens = "sine-law"
k = 400.0
principal_point = [200.0, 150.0]
[laser]
baseline = "60 mm"
aim = "20 deg"
"""
SCAN = """format = "calibore-scan/1"
name = "side"
rig = "rig.toml"
[pipe]
nominal_radius = "150 mm"
[images]
pattern = "ring {station}.png"
[motion]
axial = { origin = "0 m", step = "1 m" }
"""


def test_a_rig_that_draws_no_ring_ahead_is_refused_in_one_sentence(tmp_path):
    (tmp_path / "rig.toml").write_text(SIDE)
    (tmp_path / "scan.toml").write_text(SCAN)
    with pytest.raises(InputError, match=r"side-facing rig, but .* a scan of laser rings ahead"):
        prepare(read_scan(tmp_path), estimator="zero-crossing")


def test_takes_that_were_left_alone_are_told_in_one_sentence():
    assert unlit_sentence({0: 1}).startswith("1 image was not looked at")
    assert unlit_sentence({0: 3, 4: 2}).startswith("5 images were not looked at")
    assert "takes 0, 4" in unlit_sentence({0: 3, 4: 2})


def test_every_parameter_of_every_laser_is_listed_with_its_unit():
    rows = describe_rig(Job.of(rig((1,), (2,)), RADIUS), file=None)["parameters"]
    units = {row["name"]: row["unit"] for row in rows}
    assert set(rig((1,), (2,)).parameter_names) == set(units)
    assert {units[f"laser.{n}.{name}"] for n in (0, 1) for name in ("aim", "half_angle", "clock")} == {"rad"}
    assert {units[f"laser.{n}.{name}"] for n in (0, 1) for name in ("baseline", "offset")} == {"m"}
    stated = {row["name"] for row in rows if row["u"] is not None}
    assert stated == {f"laser.{n}.{name}" for n in (0, 1) for name in ("baseline", "aim", "half_angle")}


@pytest.mark.parametrize("seed", range(6))
def test_a_cones_ring_is_looked_for_wherever_walls_near_the_nominal_one_show_it(seed):
    rng = np.random.default_rng(seed)
    camera = Camera(1024, 768, Lens("sine-law", 570.0, 384.0), (512.0, 384.0))
    cone = Cone.for_ring(RADIUS * rng.uniform(0.2, 0.8), RADIUS * rng.uniform(1, 2.5), RADIUS, clock=rng.uniform(0, 6))
    here = Rig("single-cone", camera, (Laser(cone, "red"),))
    search = search_region(here, RADIUS, inner=0.5, outer=1.5)
    for factor in (0.9, 1.0, 1.2):
        _, u, v = project_ring(here, factor * RADIUS, 360)
        distance = np.hypot(u - search.centre[0], v - search.centre[1])
        assert search.inner <= np.nanmin(distance) + 1
        assert np.nanmax(distance) <= search.outer + 1

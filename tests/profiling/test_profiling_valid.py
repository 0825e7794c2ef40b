"""A calibrated rig downstream: all correlations reach u_common, what lies beyond its points is flagged but not lost."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_profiling_station import HEIGHT, RADIUS, WIDTH, station

from calibore.calibration import Calibration, InputFile, Observations, write_calibration
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import Job, Tally, measure_image, measure_station, profile_scan
from calibore.profiling._fusion import fuse_lasers
from calibore.profiling._grid import Ring, clock_grid
from calibore.profiling._placement import Placement
from calibore.profiling._summary import warnings_of
from calibore.profiling._takes import combine_takes
from calibore.rigs import Laser, Rig, ValidRegion, triangulate
from calibore.rigs._valid import TOLERANCE
from calibore.scans import open_profile
from calibore.simulation import Ovality, PipeWall, Sensor, Station, Survey, render_ring, simulate_scan
from calibore.status import Status, has_value
from calibore.uncertainty import Covariance

NAMES = ("laser.baseline", "camera.k")
U = np.array([1e-3, 0.5])
"""m, px: each alone moves the radius by much the same."""
WALL = PipeWall(RADIUS, (Ovality((4.0, 4.0), axial=(0.0, 1.0), axis=0.0),))
LEVEL = Pose.from_roll_pitch_yaw(0.0, 0.0, 0.0, translation=(0.0, 0.0, 0.0))
REGION = ValidRegion(radius=(0.1, RADIUS))


def rig(correlation: float = 0.0, *, valid: ValidRegion | None = None) -> Rig:
    camera = Camera(WIDTH, HEIGHT, Lens("sine-law", 190.0, HEIGHT / 2), (WIDTH / 2, HEIGHT / 2))
    covariance = Covariance.correlated(dict(zip(NAMES, U.tolist(), strict=True)), {NAMES: correlation})
    return Rig("perpendicular-plane", camera, (Laser(Plane(0.32), "red"),), covariance=covariance, valid=valid)


def calibrated(rig: Rig) -> Calibration:
    """What a calibration of `rig` would have written."""
    none, whole = np.zeros(0), np.zeros(0, dtype=np.intp)
    return Calibration(
        kind="ring-gauge",
        rig=rig,
        camera=rig.camera,
        values={"laser.baseline": 0.32, "camera.k": 190.0},
        covariance=rig.covariance,
        degrees_of_freedom=20.0,
        noise=0.1,
        group_sigma=0.0,
        files=(InputFile("gauge.png", "0" * 64),),
        observations=Observations(whole, none, none, none, none, none, whole, np.zeros((0, 2)), NAMES),
        valid=rig.valid,
    )


@pytest.fixture(scope="module")
def picture():
    """Of an oval pipe, widest at the crown."""
    return render_ring(rig(), WALL, pipe_from_rig=LEVEL, rng=np.random.default_rng(1), sensor=Sensor.perfect(bits=8))


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    folder = tmp_path_factory.mktemp("survey")
    stations = (Station(0), Station(1, takes=2))
    return simulate_scan(folder / "scan", Survey("oval", rig(), WALL, stations, 0.1, 0.1, LEVEL), seed=1)


@pytest.mark.parametrize("correlation", [-0.98, 0.0, 0.9, 0.999])
def test_the_common_uncertainty_knows_of_the_correlation_in_the_calibration_file(scan, tmp_path, correlation):
    """R = D tan(zenith(r / k)): baseline and k move it opposite ways, so what they share cancels."""
    (scan / "rig.toml").unlink(missing_ok=True)
    write_calibration(calibrated(rig(correlation)), scan / "rig.toml")
    summary = profile_scan(scan, tmp_path / "out", workers=1)
    profile = open_profile(tmp_path / "out")
    ring = profile.isel(station=0)
    radius = ring["radius"].to_numpy()
    u, v = rig().project(
        np.stack([radius * np.sin(ring["clock"]), -radius * np.cos(ring["clock"]), 0.32 + 0 * radius], 1)
    )
    by = triangulate(rig(), u, v)
    s = by.radius_sensitivities.parameters[:, [by.parameter_names.index(name) for name in NAMES]] * U
    expected = np.sqrt(s[:, 0] ** 2 + s[:, 1] ** 2 + 2 * correlation * s[:, 0] * s[:, 1])
    assert np.nanmax(np.abs(ring["u_common"].to_numpy() / expected - 1)) < 0.02  # mean of the rays of a step
    assert summary["rig"]["degrees_of_freedom"] == 20.0


def test_correlations_that_are_ignored_change_the_answer_many_times_over(picture):
    rings = [measure_image(picture, Job.of(rig(correlation), RADIUS)) for correlation in (0.0, 0.999)]
    apart, together = (float(np.nanmean(np.sqrt(np.sum(ring.modes**2, axis=0)))) for ring in rings)
    assert apart > 5 * together


def test_points_beyond_the_calibrated_radius_are_flagged_and_keep_their_value(picture):
    plain = measure_station(station(picture), Placement(1.0), Job.of(rig(), RADIUS))
    found = measure_station(station(picture), Placement(1.0), Job.of(rig(valid=REGION), RADIUS))
    low, high = REGION.radius
    beyond = plain.points.radius > high + TOLERANCE * (high - low)
    assert 0.1 < beyond.mean() < 0.9
    assert np.array_equal(found.points.status == Status.EXTRAPOLATED, beyond)
    assert np.array_equal(found.points.status[~beyond], plain.points.status[~beyond])
    for name in ("radius", "u_independent", "common_mode", "axial_position"):
        assert np.array_equal(getattr(found.profile, name), getattr(plain.profile, name), equal_nan=True)
    flagged = found.profile.status == Status.EXTRAPOLATED
    assert np.isfinite(found.profile.radius[flagged]).all()
    edge = np.abs(found.profile.radius - (high + TOLERANCE * (high - low))) < 1e-4
    assert np.array_equal(flagged[~edge], (found.profile.radius > high + TOLERANCE * (high - low))[~edge])
    assert found.quantities == plain.quantities


def test_so_are_rays_beyond_the_calibrated_zenith(picture):
    zenith = np.arctan2(RADIUS, 0.32)
    found = measure_station(
        station(picture), Placement(1.0), Job.of(rig(valid=ValidRegion((0.0, zenith))), RADIUS)
    ).points
    measured = has_value(found.status)
    wide = np.arctan2(found.radius, 0.32) > zenith * (1 + TOLERANCE)
    assert 0.1 < wide[measured].mean() < 0.9
    assert np.array_equal((found.status == Status.EXTRAPOLATED)[measured], wide[measured])


def test_a_region_that_holds_the_pipe_changes_nothing(picture):
    rigs = (rig(), rig(valid=ValidRegion((0.0, 1.0), (0.05, 0.5))))
    plain, found = (measure_station(station(picture), Placement(1.0), Job.of(one, RADIUS)) for one in rigs)
    assert np.array_equal(plain.points.status, found.points.status)
    assert np.array_equal(plain.profile.status, found.profile.status)


def ring_of(status: int, *, u: float = 1e-4, axial: float = 0.3) -> Ring:
    n = clock_grid().size
    radius = np.full(n, 0.15 if has_value(np.array(status)) else np.nan)
    kind = np.full(n, status, dtype=np.uint8)
    return Ring(
        clock_grid(), radius, np.full(n, axial), u + 0 * radius, np.zeros((1, n)) + 0 * radius, kind, np.zeros(3)
    )


@pytest.mark.parametrize("other", Status)
def test_what_is_extrapolated_in_part_is_extrapolated(other):
    """Of two takes, and of two lasers that agree."""
    extrapolated, another = ring_of(Status.EXTRAPOLATED), ring_of(other)
    for rings in ([extrapolated, another], [another, extrapolated]):
        for one in (combine_takes(rings)[0], fuse_lasers(rings)):
            assert (one.status == Status.EXTRAPOLATED).all()
            assert np.isfinite(one.radius).all()


def test_a_laser_that_was_not_chosen_does_not_count():
    chosen, other = ring_of(Status.OK), ring_of(Status.EXTRAPOLATED, u=1e-2, axial=0.6)
    assert (fuse_lasers([chosen, other]).status == Status.OK).all()


def test_the_summary_counts_them_as_measured_and_names_the_region(picture):
    job, tally = Job.of(rig(valid=REGION), RADIUS), Tally()
    result = measure_station(station(picture), Placement(1.0), job)
    tally.add(result)
    count = int((result.profile.status == Status.EXTRAPOLATED).sum())
    assert tally.measured == np.isfinite(result.profile.radius).sum()
    said = [warning for warning in warnings_of(job, tally) if "outside the region" in warning]
    assert len(said) == 1
    assert f"{count} positions" in said[0]
    assert "radius 100 to 150 mm" in said[0]
    assert "Calibrate" in said[0]
    none = replace(job, rig=rig())
    assert not any("outside the region" in warning for warning in warnings_of(none, tally))


def test_a_status_keeps_its_stored_number_for_ever():
    """Results of earlier versions hold them (tests/golden)."""
    stored = (
        "ok resolved saturated no_peak multiple off_ring not_laser outside_lens grazing behind no_image extrapolated "
        "stuck off_tip no_reading water"
    )
    assert [status.name.lower() for status in Status] == stored.split()
    assert [int(status) for status in Status] == list(range(len(Status)))
    assert [status for status in Status if status.has_value] == [0, 1, 2, Status.EXTRAPOLATED]
    assert np.array_equal(has_value(np.arange(len(Status))), [status.has_value for status in Status])


def test_the_flags_in_a_result_of_version_0_1_mean_what_they_mean_now():
    flags = open_profile(Path(__file__).parents[1] / "golden" / "v1")["status"].attrs
    named = dict(zip(flags["flag_meanings"].split(), flags["flag_values"], strict=True))
    assert all(Status[name.upper()] == value for name, value in named.items())

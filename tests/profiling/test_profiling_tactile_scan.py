"""A scan folder of voltages becomes a profile like any other, whose intervals hold the wall."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tactile_walls import INCH, INTERCEPT, NOMINAL, PROBE, SCAN, SLOPE, random_pipe, scanned, written

from calibore.cli import main
from calibore.profiling import profile_scan
from calibore.profiling._tactile._neighbours import Grid
from calibore.profiling._tactile._readings import Readings
from calibore.profiling._tactile._rings import measure_wall
from calibore.rigs import Probe, read_probe
from calibore.scans import open_points, open_profile, read_rings, read_scan
from calibore.status import Status
from calibore.uncertainty import Covariance

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "tactile"


@pytest.fixture(scope="module")
def made():
    rng = np.random.default_rng(11)
    return scanned(random_pipe(rng), rng, rings=12)


@pytest.fixture(scope="module")
def out(made, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tactile")
    profile_scan(written(folder / "scan", made.reading), folder / "out")
    return folder / "out"


def test_the_profile_has_a_row_for_each_ring_of_the_table_and_a_column_for_each_stop(made, out):
    with open_profile(out) as profile:
        assert np.array_equal(profile["station"], np.arange(12))
        assert np.allclose(profile["axial"], made.axial)
        assert np.allclose(profile["clock"], made.clock)
        measured = np.isfinite(profile["radius"].values)
        assert np.array_equal(np.isfinite(profile["u_independent"]), measured)
        assert np.allclose(profile["axial_position"].values[measured], (made.axial[:, None] + 0 * made.wall)[measured])
        assert set(np.unique(profile["status"])) <= {Status.OK, Status.STUCK, Status.OFF_TIP}
        error = (profile["radius"].values - made.wall)[measured & ~made.bad]
    assert np.sqrt(np.mean(error**2)) < 0.0012 * INCH


def test_points_are_where_the_ball_touched_and_have_no_pixel(made, out):
    with open_points(out) as points:
        assert points.sizes["point"] == made.reading.size
        assert np.isnan(points["u"]).all()
        assert np.isnan(points["v"]).all()
        radius, x, y = (points[name].values for name in ("radius", "x", "y"))
        assert np.allclose(np.hypot(x, y)[np.isfinite(radius)], radius[np.isfinite(radius)], atol=1e-7)
        aside = points["axial"].values - np.repeat(made.axial, made.clock.size)
    assert 0.2 * INCH / 16 < np.nanmax(np.abs(aside)) <= INCH / 16


def test_flagged_readings_have_no_part_in_the_quantities_of_a_ring(made, tmp_path):
    """A stuck pin 0.7 in too far out would make the largest diameter that much larger."""
    rng = np.random.default_rng(4)
    plain = scanned(random_pipe(rng, sharp=False), rng, rings=3, stick=0.0)
    stuck = plain.reading.copy()
    stuck[:, ::37] += 0.7 * INCH
    for name, reading in (("plain", plain.reading), ("stuck", stuck)):
        profile_scan(written(tmp_path / name, reading), tmp_path / f"{name}-out")
    one, other = (read_rings(tmp_path / f"{name}-out") for name in ("plain", "stuck"))
    assert np.allclose(one["diameter_max_m"], other["diameter_max_m"], atol=1e-4)
    assert np.allclose(one["diameter_mean_m"], other["diameter_mean_m"], atol=1e-4)


def test_the_direction_and_the_start_of_the_stops_do_not_matter(made, out, tmp_path):
    backwards = np.roll(made.reading[:, ::-1], 31, axis=1)
    scan = SCAN.replace('origin = "0 deg", step = "0.9 deg"', f'origin = "{(31 - 1) * 0.9:.1f} deg", step = "-0.9 deg"')
    profile_scan(written(tmp_path / "scan", backwards, scan=scan), tmp_path / "out")
    with open_profile(out) as one, open_profile(tmp_path / "out") as other:
        assert np.array_equal(one["clock"], other["clock"])
        assert np.allclose(one["radius"], other["radius"], equal_nan=True, atol=1e-10)


def test_a_motion_table_places_the_rings_and_those_it_does_not_know_are_left_out(made, tmp_path):
    scan = SCAN.replace('axial = { origin = "0 in", step = "0.1 in" }', 'table = "stations.csv"')
    folder = written(tmp_path / "scan", made.reading, scan=scan)
    rows = [f"{row},{1 + axial:.6f},0.1" for row, axial in enumerate(made.axial) if row != 5]
    (folder / "stations.csv").write_text("station,axial_m,roll_rad\n" + "\n".join(rows) + "\n")
    summary = profile_scan(folder, tmp_path / "out")
    with open_profile(tmp_path / "out") as profile:
        assert 5 not in profile["station"]
        assert np.allclose(profile["axial"], 1 + np.delete(made.axial, 5))
        assert np.allclose(profile["roll"], 0.1)
    assert summary["counts"]["refused_readings"] == 400
    assert any("1 ring: 5" in warning for warning in summary["warnings"])


def test_beyond_the_calibrated_stroke_a_reading_counts_but_is_marked(made, tmp_path):
    folder = written(tmp_path / "scan", made.reading)
    (folder / "probe.toml").write_text(PROBE.replace("[0.02, 0.66]", "[0.30, 0.66]"))
    summary = profile_scan(folder, tmp_path / "out")
    with open_profile(tmp_path / "out") as profile:
        status, radius = profile["status"].values, profile["radius"].values
    beyond = (made.reading - INTERCEPT) / SLOPE < 0.30 - 0.02 * 0.36
    assert (status[beyond & np.isfinite(radius)] == Status.EXTRAPOLATED).all()
    assert (status[~beyond] != Status.EXTRAPOLATED).all()
    assert any("outside the stroke" in warning for warning in summary["warnings"])


def test_missing_and_impossible_voltages_cost_only_their_own_points(made, tmp_path):
    folder = written(tmp_path / "scan", made.reading)
    rows = [line.split(",") for line in (folder / "signal.csv").read_text().split()]
    rows[3][7], rows[4][8], rows[5] = "", "7.5", ["nan"] * 400
    (folder / "signal.csv").write_text("\n".join(map(",".join, rows)) + "\n")
    summary = profile_scan(folder, tmp_path / "out")
    with open_profile(tmp_path / "out") as profile:
        lost = profile["status"].values == Status.NO_READING
    assert lost[3, 7]
    assert lost[4, 8]
    assert lost[5].all()
    assert lost.sum() == summary["counts"]["refused_readings"] == 402


def test_the_probe_may_be_given_by_hand(made, out, tmp_path):
    folder = written(tmp_path / "scan", made.reading, scan=SCAN.replace('probe = "probe.toml"\n', ""))
    for number, probe in enumerate((folder / "probe.toml", read_probe(folder / "probe.toml"))):
        profile_scan(folder, tmp_path / str(number), probe=probe)
        with open_profile(out) as one, open_profile(tmp_path / str(number)) as other:
            assert np.array_equal(one["radius"], other["radius"], equal_nan=True)


def test_the_intervals_hold_the_wall_over_calibrations_that_are_wrong_by_chance():
    """Slope, intercept, bend and drift drawn anew each time: what all readings share is off together."""
    rng = np.random.default_rng(21)
    pipe = random_pipe(rng, sharp=False)
    base = scanned(pipe, rng, rings=6, stops=200, noise=0.0, stick=0.0)
    covariance = Covariance(("probe.slope", "probe.intercept"), [[2.6e-10, -6e-11], [-6e-11, 2.5e-10]])
    stated = Probe(SLOPE, INTERCEPT, covariance, 0.0006 * INCH, linearity=2e-5, stroke=(0.02, 0.66))
    drift, inside = 1.5e-5, []
    for _ in range(300):
        slope, intercept = rng.multivariate_normal((SLOPE, INTERCEPT), covariance.matrix)
        truth = replace(stated, slope=slope, intercept=intercept)
        bend = stated.common_modes((base.contact - INTERCEPT) / SLOPE)[..., 2] * rng.standard_normal()
        wander = drift * rng.standard_normal() + bend + stated.noise * rng.standard_normal(base.contact.shape)
        ratio = (base.contact + wander - truth.intercept) / truth.slope
        readings = Readings(ratio, Grid(base.clock, base.axial, INCH / 16), tuple(range(6)), ())
        wall = measure_wall(readings, stated, drift=drift)
        u = np.hypot(wall.contact.u, np.linalg.norm(wall.modes, axis=0))
        inside.append(np.mean(np.abs(wall.contact.radius - base.wall)[3] <= 1.96 * u[3]))
    assert 0.93 < np.mean(inside) < 0.97


def test_one_ring_is_a_scan_too(made, tmp_path):
    summary = profile_scan(written(tmp_path / "scan", made.reading[:1]), tmp_path / "out")
    assert summary["counts"]["stations"] == 1
    assert any("one ring only" in warning for warning in summary["warnings"])


def test_stops_too_far_apart_to_tell_an_edge_are_told(tmp_path):
    scan = SCAN.replace('step = "0.9 deg"', 'step = "10 deg"')
    reading = np.full((3, 36), NOMINAL)
    summary = profile_scan(written(tmp_path / "scan", reading, scan=scan), tmp_path / "out")
    assert any("The stops are" in warning for warning in summary["warnings"])
    assert summary["statuses"] == {"ok": 108}


@pytest.mark.skipif(not SHARED.is_dir(), reason=f"no shared data at {SHARED}")
def test_the_shared_scan_meets_the_issues_limits_and_the_command_makes_its_probe(tmp_path, capsys, monkeypatch):
    """Truth comes from another renderer: rms on good points, flags, and intervals where the wall is smooth."""
    scan = tmp_path / "scan"
    scan.mkdir()
    for name in SHARED.iterdir():
        if name.suffix in {".csv", ".toml"}:
            shutil.copy(name, scan)
    arguments = ["calibore", "profile", str(scan), "--out", str(tmp_path / "out"), "--no-pictures"]
    monkeypatch.setattr(sys, "argv", arguments)
    with pytest.raises(SystemExit) as left:
        main()
    assert not left.value.code
    said = capsys.readouterr()
    assert "names no probe; calibrated one from" in said.err
    assert "100 stations from 40000 readings" in said.out
    assert read_probe(tmp_path / "out" / "probe.toml").noise > 0
    truth = np.load(SHARED / "truth.npz")
    bad, wall = truth["stuck"] | truth["off_tip"], truth["R_geometric"] * INCH
    with open_profile(tmp_path / "out") as profile:
        radius = profile["radius"].values
        u = np.hypot(profile["u_independent"].values, profile["u_common"].values)
    flagged, error = np.isnan(radius), radius - wall
    assert flagged[bad].mean() >= 0.95
    assert flagged[~bad].mean() <= 0.03
    good = ~flagged & ~bad
    assert np.sqrt(np.mean(error[good] ** 2)) < 0.0015 * INCH
    smooth = good & (np.hypot(*np.gradient(wall)) < 0.01 * INCH)
    assert 0.93 < np.mean(np.abs(error[smooth]) <= 1.96 * u[smooth]) < 0.975


def test_a_scan_names_its_probe_and_what_it_drifts_by(made, tmp_path):
    tables = read_scan(written(tmp_path, made.reading)).tactile
    assert tables is not None
    assert tables.probe == (tmp_path / "probe.toml").resolve()
    assert tables.drift == 0

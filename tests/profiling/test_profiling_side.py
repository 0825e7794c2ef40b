"""Scans of side-facing heads: the wall where it is, known as well as it is said to be, nothing invented."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from side_scans import perfect, scan_of, side_survey, true_radius

from calibore.geometry import Pose
from calibore.profiling import profile_scan
from calibore.scans import open_points, open_profile, read_rings
from calibore.simulation import Dent, LateralOpening, PipeWall, Survey
from calibore.status import Status

SHARED = Path(__file__).parents[2].parent / "shared"
SIDE = SHARED / "data" / "simulated" / "side-2.4in"


def profile_of(survey: Survey, folder: Path, *, seed: int = 1, **options: Any) -> tuple[Any, dict[str, Any]]:
    summary = profile_scan(scan_of(survey, folder / "scan", seed=seed), folder / "out", workers=1, **options)
    return open_profile(folder / "out").load(), summary


def errors(survey: Survey, profile: Any) -> tuple[np.ndarray, np.ndarray]:
    """Errors (n,) [m] of all cells with a value, and which cells (a, c) they are."""
    found = np.isfinite(profile.radius.values)
    axial, clock = np.meshgrid(profile.axial.values, profile.clock.values, indexing="ij")
    radius = profile.radius.values[found]
    return radius - true_radius(survey, axial[found], clock[found], radius), found


@pytest.mark.skipif(not SIDE.exists(), reason="needs the shared side-facing survey")
def test_the_shared_survey_is_measured_as_well_as_asked(tmp_path: Path) -> None:
    sys.path.insert(0, str(SHARED / "tools"))
    from score import score_side  # pyright: ignore[reportMissingImports]

    profile_scan(SIDE, tmp_path / "out", workers=2)
    score = score_side(tmp_path / "out", SIDE / "truth.npz")
    assert score["rms_in"] < 0.0035
    assert score["missed_pct"] <= 2
    assert score["outlier_pct"] == 0
    # the rig file happens to be exactly right: what is stated of the calibration comes on top of the noise, which alone
    # holds 93.8 %
    assert 90 <= score["cover95_pct"] < 99.8
    profile = open_profile(tmp_path / "out")
    u = profile.u_independent.values[np.isfinite(profile.u_independent.values)] / 0.0254
    told = u < 10 * np.median(u)  # the others say themselves that next to nothing is known of them
    assert told.mean() > 0.995
    noise = np.sqrt(np.mean(u[told] ** 2))
    assert score["rms_in"] == pytest.approx(noise, rel=0.1)


def test_stated_uncertainty_holds_over_random_heads(tmp_path: Path) -> None:
    """The noise for each cell; the calibration, common to a scan, through the modes that say what it can do."""
    noise, common, modes = [], 0.0, 0
    for seed in range(100, 110):
        survey = side_survey(seed, angles=(0, 100, 200, 300))
        profile, _ = profile_of(survey, tmp_path / str(seed), seed=seed)
        error, found = errors(survey, profile)
        u = profile.u_independent.values[found]
        by_mode = profile.common_mode.values[:, found].T / u[:, None]
        drawn = np.linalg.solve(by_mode.T @ by_mode + np.eye(by_mode.shape[1]), by_mode.T @ (error / u))
        noise.append(error / u - by_mode @ drawn)
        told = np.linalg.eigvalsh(by_mode.T @ by_mode)
        common, modes = common + float(drawn @ drawn), modes + int(np.sum(told / (1 + told) > 0.5))
    z = np.concatenate(noise)
    assert 0.93 < np.mean(np.abs(z) < 1.96) < 0.97
    assert 0.92 < np.sqrt(np.mean(z**2)) < 1.08
    assert 0.3 * modes < common < 2.2 * modes  # chi-square with some 30 degrees of freedom, 99.9 %


def test_a_perfect_picture_gives_the_wall(tmp_path: Path) -> None:
    survey = perfect(side_survey(5, angles=tuple(range(20)), stations=2))
    profile, summary = profile_of(survey, tmp_path)
    error, found = errors(survey, profile)
    assert np.sqrt(np.mean(error**2)) < 2e-4 * survey.wall.nominal_radius  # a tenth of a pixel
    assert summary["counts"]["stops"] == 40
    np.testing.assert_array_equal(np.flatnonzero(found.any(axis=0)), np.arange(20))
    assert (profile.status.values[:, 20:] == Status.NO_IMAGE).all()


def test_the_grid_lies_at_multiples_of_its_step_and_says_where(tmp_path: Path) -> None:
    profile, summary = profile_of(side_survey(6, angles=(0, 399)), tmp_path)
    step = summary["grid"]["axial_step_m"]
    axial, found = profile.axial.values, np.isfinite(profile.radius.values)
    np.testing.assert_allclose(axial / step, np.rint(axial / step), atol=1e-6)
    np.testing.assert_allclose(np.diff(axial), step)
    np.testing.assert_array_equal(profile.station.values, np.arange(axial.size))
    np.testing.assert_allclose(profile.axial_position.values[found], np.repeat(axial, 400).reshape(-1, 400)[found])
    np.testing.assert_allclose(profile.clock.values, np.arange(400) * np.radians(0.9))


def test_the_spacing_can_be_said(tmp_path: Path) -> None:
    survey = side_survey(6, angles=(0, 100))
    scan = scan_of(survey, tmp_path / "scan")
    with (scan / "scan.toml").open("a") as file:
        file.write('\n[grid]\naxial_step = "5 mm"\n')
    profile_scan(scan, tmp_path / "out", workers=1)
    np.testing.assert_allclose(np.diff(open_profile(tmp_path / "out").axial.values), 0.005)


def test_overlapping_stops_are_better_than_one(tmp_path: Path) -> None:
    one, _ = profile_of(side_survey(8, angles=(0, 50)), tmp_path / "one")
    three, _ = profile_of(side_survey(8, angles=(0, 50), stations=3, overlap=0.9), tmp_path / "three")
    middle = slice(three.axial.size // 2 - 3, three.axial.size // 2 + 3)
    gain = np.nanmedian(one.u_independent.values) / np.nanmedian(three.u_independent.values[middle])
    assert 1.4 < gain < 2.1  # root of 3
    assert np.nanmedian(three.u_common.values) == pytest.approx(np.nanmedian(one.u_common.values), rel=0.1)


def test_takes_gain_what_their_speckle_does_not_share(tmp_path: Path) -> None:
    survey = side_survey(9, angles=(0, 100, 200), takes=4)
    profile, summary = profile_of(survey, tmp_path)
    assert 0.1 < summary["take_correlation"] < 0.95
    error, found = errors(survey, profile)
    assert found.any()
    assert np.isfinite(error).all()
    points = open_points(tmp_path / "out")
    assert sorted(np.unique(points["take"].values)) == [0, 1, 2, 3]


def test_no_wall_is_invented_where_none_was_seen(tmp_path: Path) -> None:
    """A gap between stops stays one; so does a strip that a step of the wall hides from the camera."""
    survey = side_survey(10, angles=(0, 100), stations=2, overlap=-1.0)
    profile, _ = profile_of(survey, tmp_path)
    rows = np.isfinite(profile.radius.values[:, 0])
    inside = np.flatnonzero(rows)
    gap = np.diff(inside).max()
    assert gap > 10
    silent = ~rows[inside[0] : inside[-1]]
    assert (profile.status.values[inside[0] : inside[-1], 0][silent] >= Status.NO_PEAK).all()


def test_the_strip_that_a_step_hides_stays_empty(tmp_path: Path) -> None:
    """The floor of a hole begins behind its rim: between them the camera sees no light, and the grid has no number."""
    radius, depth = 0.15, 0.02
    hole = LateralOpening(0.02, depth, np.pi / 2, 0.018, edge=0.0005)
    survey = side_survey(14, angles=(100, 101), wall=PipeWall(radius, (hole,)))
    survey = replace(perfect(survey), origin=0.0, pose=Pose.identity())
    profile, _ = profile_of(survey, tmp_path)
    along, status = profile.radius.values[:, 100], profile.status.values[:, 100]
    with np.load(tmp_path / "scan" / "truth.npz") as truth:
        seen = truth["row_visible"][0, 0]
        lit = 0.0254 * truth["row_rig_H"][0, 0][seen]
    rim, floor = lit[lit < 0].max(), lit[lit > 0].min()
    cells, half = profile.axial.values, np.diff(profile.axial.values)[0] / 2
    hidden = (cells - half > rim) & (cells + half < floor)
    assert (status[hidden] == Status.NO_PEAK).any()
    # a line of light has a width: beside the shadow a part of it is seen, and tells of the floor or of the rim
    level = np.where(np.abs(along - radius) < depth / 2, radius, radius + depth)
    found = np.isfinite(along)
    np.testing.assert_allclose(along[found], level[found], atol=1e-4)
    assert (level[found & (cells < rim - half)] == radius).all()
    assert (level[found & (cells > floor + half)] == radius + depth).all()


def test_points_keep_their_stop_and_lie_on_the_wall(tmp_path: Path) -> None:
    survey = perfect(side_survey(11, angles=(0, 133), stations=2))
    profile_of(survey, tmp_path)
    points = open_points(tmp_path / "out").load()
    assert sorted(np.unique(points.station.values)) == [0, 1]
    seen = points.status.values <= Status.SATURATED
    wall = np.stack([points[name].values[seen] for name in "xyz"], axis=1).astype(float)
    assert np.abs(survey.wall.depth(survey.pose.apply(wall))).max() < 2e-3 * survey.wall.nominal_radius
    second = points.station.values[seen] == 1
    assert wall[second, 2].mean() - wall[~second, 2].mean() == pytest.approx(survey.step, rel=0.1)


def test_threads_change_nothing(tmp_path: Path) -> None:
    scan = scan_of(side_survey(12, angles=tuple(range(0, 400, 100)), stations=2), tmp_path / "scan")
    for workers in (1, 3):
        profile_scan(scan, tmp_path / str(workers), workers=workers)
    one, three = (open_profile(tmp_path / name).load() for name in ("1", "3"))
    assert one.identical(three)
    assert (tmp_path / "1" / "rings.csv").read_bytes() == (tmp_path / "3" / "rings.csv").read_bytes()


def test_a_dent_is_found_with_its_depth(tmp_path: Path) -> None:
    radius = 0.15
    wall = PipeWall(radius, (Dent(0.01, np.pi / 2, -0.1 * radius, 0.2, 0.05),))
    survey = side_survey(13, angles=tuple(range(80, 121, 2)), wall=wall)
    profile, _ = profile_of(survey, tmp_path)
    error, _ = errors(survey, profile)
    assert np.sqrt(np.mean(error**2)) < 3 * np.nanmean(np.hypot(profile.u_independent.values, profile.u_common.values))
    rings = read_rings(tmp_path / "out")
    assert rings["station"].size == profile.station.size

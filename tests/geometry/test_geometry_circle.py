"""Circles by orthogonal distances: reference fits, honest covariance, robustness."""

import time
from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import fit_circle, xy_of

NIST = Path(__file__).parents[2].parent / "shared" / "data" / "real" / "nist-circles"
REFERENCE_WITHIN = 1e-6  # asked for by the NIST comparison; we reach 1e-12


@pytest.mark.parametrize("number", range(1, 16))
def test_nist_reference_circles_are_reproduced(number):
    if not NIST.is_dir():
        pytest.skip(f"{NIST} is absent: the NIST circles are not checked")
    rows = [line.split() for line in (NIST / f"cir2d{number}.ds").read_text().splitlines()]
    points = np.array([row for row in rows if len(row) == 3], dtype=float)
    reference = np.array((NIST / f"cir2d{number}.fit").read_text().split(), dtype=float)
    across = [axis for axis in range(3) if abs(reference[3 + axis]) < 0.5]  # all normals are along an axis
    fit = fit_circle(points[:, across])
    assert np.allclose(fit.centre, reference[across], rtol=0, atol=REFERENCE_WITHIN)
    assert 2 * fit.radius == pytest.approx(reference[6], abs=REFERENCE_WITHIN)


def test_the_example_of_gander_golub_and_strebel_is_reproduced():
    fit = fit_circle(np.array([(1, 7), (2, 6), (5, 8), (7, 7), (9, 5), (3, 7)]))
    assert np.allclose([*fit.centre, fit.radius], [4.73978, 2.98353, 4.71423], rtol=0, atol=5e-6)  # printed digits


def ring(rng, *, n=400, centre=(0.01, -0.02), radius=0.15, arc=2 * np.pi, noise=0.0):
    clock = rng.uniform(0, 2 * np.pi) + np.linspace(0, arc, n, endpoint=False)
    return np.column_stack(xy_of(clock, radius + noise * rng.normal(size=n))) + centre


@pytest.mark.parametrize("arc", [0.2, 0.7, 2.0, 2 * np.pi])
@pytest.mark.parametrize("robust", [False, True])
def test_an_exact_circle_is_found_exactly_from_any_arc_far_from_the_origin(arc, robust):
    rng = np.random.default_rng(4)
    fit = fit_circle(ring(rng, centre=(300.0, -700.0), radius=5.0, arc=arc), robust=robust)
    tolerance = 1e-11 / (arc / (2 * np.pi)) ** 2  # coordinates round to 1e-13; the centre follows the square of the arc
    assert np.allclose([*fit.centre, fit.radius], [300.0, -700.0, 5.0], rtol=0, atol=tolerance)


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("stated", [False, True])
@pytest.mark.parametrize("arc", [2.0, 2 * np.pi])
def test_the_stated_covariance_is_the_scatter_of_many_fits(robust, stated, arc):
    rng, truth, noise, runs = np.random.default_rng(5), np.array([0.01, -0.02, 0.15]), 2e-4, 250
    scores = []
    for _ in range(runs):
        fit = fit_circle(ring(rng, n=150, arc=arc, noise=noise), sigma=noise if stated else None, robust=robust)
        error = np.array([*fit.centre, fit.radius]) - truth
        scores.append(error @ np.linalg.solve(fit.covariance, error))
    assert np.mean(scores) == pytest.approx(3, abs=4 * np.sqrt(6 / runs))  # chi-squared of 3, four standard deviations


def test_unequal_sigma_lets_the_better_points_decide():
    rng = np.random.default_rng(6)
    points, sigma = ring(rng, n=200), np.where(np.arange(200) % 2, 1e-5, 1e-2)
    points += sigma[:, None] * rng.normal(size=(200, 2))
    fit = fit_circle(points, sigma=sigma)
    assert abs(fit.radius - 0.15) < 4 * fit.u_radius < 1e-5
    assert (np.abs(fit.centre - [0.01, -0.02]) < 4 * fit.u_centre).all()


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("kind", ["one feature", "scattered", "missing arc and feature"])
def test_features_on_thirty_percent_of_a_ring_do_not_pull_a_robust_fit(seed, kind):
    rng, n, noise = np.random.default_rng(seed), 400, 1e-4
    points = ring(rng, noise=noise)
    offset = points - (0.01, -0.02)
    bad = np.arange(n) < 120 if kind != "scattered" else rng.permutation(n) < 120
    depth = np.where(bad, rng.uniform(0.05, 0.3, n) if kind == "scattered" else 0.13, 0.0)
    points = (0.01, -0.02) + offset * (1 - depth[:, None])
    if kind == "missing arc and feature":
        points[200:320] = np.nan
        points[:60] = np.nan
    fit = fit_circle(points, robust=True)
    assert (np.abs(fit.centre - [0.01, -0.02]) < 5 * fit.u_centre).all()
    assert abs(fit.radius - 0.15) < 5 * fit.u_radius < 5 * noise
    assert not fit.inliers[bad].any()
    assert np.abs(fit_circle(points).radius - 0.15) > 10 * fit.u_radius  # the plain fit is pulled: the test can fail


def test_a_robust_fit_keeps_an_oval_pipe_whole():
    clock = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    points = np.column_stack(xy_of(clock, 0.15 * (1 + 0.04 * np.cos(2 * clock)))) + np.array([0.01, 0.02])
    fit = fit_circle(points, robust=True)
    assert fit.inliers.all()
    assert np.allclose(fit.centre, [0.01, 0.02], atol=1e-6)
    assert fit.radius == pytest.approx(0.15, rel=2e-3)


def test_a_missing_point_is_left_out_and_everything_else_stays():
    rng = np.random.default_rng(7)
    points = ring(rng, noise=1e-4)
    holed = np.insert(points, 10, np.nan, axis=0)
    full, fit = fit_circle(points), fit_circle(holed)
    assert np.array_equal(full.centre, fit.centre)
    assert not fit.inliers[10]
    assert np.isnan(fit.residuals[10])
    assert np.array_equal(np.delete(fit.residuals, 10), full.residuals)
    assert fit.degrees_of_freedom == 397


def test_three_points_give_a_circle_without_a_residual_variance():
    fit = fit_circle(np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]))
    assert fit.radius == pytest.approx(1.0)
    assert fit.degrees_of_freedom == 0
    assert np.isnan(fit.covariance).all()


LINE = np.column_stack([np.arange(9.0), 2 * np.arange(9.0)])


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize(
    ("points", "sentence"),
    [
        (np.zeros((2, 2)), "at least 3 points, got 2"),
        (np.full((50, 2), np.nan), "got 0 finite"),
        (np.zeros((5, 2)), "one line"),
        (LINE, "one line"),
        (np.zeros((5, 3)), r"shape \(n, 2\)"),
    ],
)
def test_points_that_determine_no_circle_are_refused_with_a_sentence(points, sentence, robust):
    with pytest.raises(InputError, match=sentence):
        fit_circle(points, robust=robust)


@pytest.mark.parametrize("sigma", [0.0, -1.0, np.nan])
def test_an_impossible_sigma_is_refused(sigma):
    with pytest.raises(InputError, match="sigma"):
        fit_circle(np.random.default_rng(0).normal(size=(9, 2)), sigma=sigma)


def test_two_robust_fits_give_identical_bytes():
    points = ring(np.random.default_rng(8), noise=1e-3)
    first, second = fit_circle(points, robust=True), fit_circle(points, robust=True)
    assert first.centre.tobytes() == second.centre.tobytes()
    assert first.covariance.tobytes() == second.covariance.tobytes()


@pytest.mark.parametrize("robust", [False, True])
def test_a_ring_of_400_points_takes_milliseconds(robust):
    points = ring(np.random.default_rng(9), noise=1e-4)
    times = []
    for _ in range(20):
        start = time.perf_counter()
        fit_circle(points, robust=robust)
        times.append(time.perf_counter() - start)
    assert min(times) < 0.01  # 0.4 ms and 1.5 ms measured; room for a busy machine

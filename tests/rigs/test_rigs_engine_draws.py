"""Monte Carlo of the engine: what its twin draws, what first order says, and what the corrected dissertation says."""

import json
from pathlib import Path

import numpy as np
import pytest
from random_engine_rigs import KINDS, random_pixels, random_rig

from calibore.errors import InputError
from calibore.lasers import Cone, Plane, ring_angles
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, margin, measure, monte_carlo, triangulate
from calibore.status import Status
from calibore.uncertainty import Covariance

SHARED = Path(__file__).parents[2].parent / "shared"
VALUES = SHARED / "reference" / "published_values.json"
BASELINE, PROJECTION, PIXELS, SPREAD = 0.5, 1.0, 1024, 1e-3
SUMMARIES = ("mean", "u", "median", "symmetric", "shortest")


def published_rig():
    """Equations.md, 5.5: baseline and projection normal with 0.001 each; aim and half angle follow them."""
    aim, half_angle, by_lengths = ring_angles(BASELINE, PROJECTION, 1.0)
    k = PIXELS / (2 * (aim + half_angle))
    jacobian = np.vstack([[1.0, 0.0], by_lengths])
    matrix = SPREAD**2 * jacobian @ jacobian.T
    covariance = Covariance(("laser.baseline", "laser.aim", "laser.half_angle"), matrix)
    camera = Camera(4096, 4096, Lens("equidistant", float(k), 2048.0), (2047.5, 2047.5))
    laser = Laser(Cone(BASELINE, float(aim), float(half_angle)))
    return Rig("single-cone", camera, (laser,), covariance=covariance)


def tangent_azimuth(rig):
    """Where the ray to the wall touches the cone, between the azimuths at which both roots are the wall."""
    from scipy.optimize import brentq

    def difference(azimuth):
        return 1.0 if wall_pixel(rig, azimuth)[2] else -1.0

    return brentq(difference, np.radians(-30), np.radians(30), xtol=1e-9)


def wall_pixel(rig, azimuth):
    """The pixel of the wall point at `azimuth` (0 at 3 o'clock, positive towards the laser), and its branch."""
    x, y = np.cos(azimuth), -np.sin(azimuth)
    meetings = rig.lasers[0].surface.meet(np.array([[x, y, 0.0]]), np.array([[0.0, 0.0, 1.0]]))
    z = meetings.distance[meetings.admissible][0]
    u, v = rig.project(np.array([[x, y, z]]))
    return u[0], v[0], int(triangulate(rig, u, v, prior_radius=1.0).branch[0])


@pytest.mark.parametrize("kind", KINDS)
def test_without_pixel_noise_engine_and_twin_draw_the_same_points(kind):
    rng = np.random.default_rng(20 + KINDS.index(kind))
    rig, laser, size = random_rig(rng, kind)
    u, v = random_pixels(rng, 13)
    options = {"u_pixel": 0.0, "draws": 203, "laser": laser, "prior_radius": size, "keep": True}
    ours, theirs = (
        monte_carlo(rig, u, v, rng=np.random.default_rng(1), kernel=kernel, **options) for kernel in ("native", "numpy")
    )
    assert np.allclose(ours.radius_draws, theirs.radius_draws, rtol=1e-10, atol=0, equal_nan=True)
    assert np.allclose(ours.axial_draws, theirs.axial_draws, rtol=1e-10, atol=1e-14, equal_nan=True)
    assert np.array_equal(ours.lost, theirs.lost)
    assert (ours.lost < 1).any()
    for quantity in ("radius", "axial"):
        a, b = getattr(ours, quantity), getattr(theirs, quantity)
        for name in SUMMARIES:
            assert np.allclose(getattr(a, name), getattr(b, name), rtol=1e-7, atol=1e-12, equal_nan=True), name
    assert np.allclose(ours.covariance, theirs.covariance, rtol=1e-6, atol=1e-16, equal_nan=True)


def test_engine_and_twin_draw_the_same_distributions_of_noisy_pixels():
    rng = np.random.default_rng(2)
    rig, laser, size = random_rig(rng, "cone")
    u, v = random_pixels(rng, 400)
    points = triangulate(rig, u, v, laser=laser, prior_radius=size)
    margins = margin(rig, u, v, branch=points.branch, u_pixel=1.0, laser=laser)
    seen = np.flatnonzero((points.status == 0) & (margins > 10))[:20]
    u, v = u[seen], v[seen]
    angle = rng.uniform(0, 2 * np.pi, u.size)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    draws = 4000
    for direction in (None, along):
        options = {"u_pixel": 1.0, "draws": draws, "laser": laser, "prior_radius": size, "direction": direction}
        ours, theirs = (
            monte_carlo(rig, u, v, rng=np.random.default_rng(1), kernel=kernel, **options)
            for kernel in ("native", "numpy")
        )
        sure = (ours.lost == 0) & (theirs.lost == 0)
        assert sure.sum() >= 8
        ratio = ours.radius.u[sure] / theirs.radius.u[sure]
        assert np.abs(np.log(ratio)).max() < 6 / np.sqrt(2 * draws)
        apart = (ours.axial.mean - theirs.axial.mean)[sure] / ours.axial.u[sure]
        assert np.abs(apart).max() < 6 / np.sqrt(draws)


def test_first_order_and_monte_carlo_agree_within_one_per_cent_from_a_margin_of_four():
    rig = published_rig()
    azimuths = np.radians([90, 70, 50, 40, -40, -60, -80, -90])
    u, v, branch = (np.array(column) for column in zip(*(wall_pixel(rig, a) for a in azimuths), strict=True))
    margins = margin(rig, u, v, branch=branch, u_pixel=1.0)
    assert margins.min() > 4
    first = measure(rig, u, v, u_pixel=1.0, branch=branch)
    drawn = monte_carlo(rig, u, v, u_pixel=1.0, branch=branch, draws=400_000, rng=np.random.default_rng(3))
    assert np.allclose(drawn.radius.u, first.u_radius, rtol=0.01)  # u of 400 000 draws is known within 0.1 %
    assert np.allclose(drawn.axial.u, first.u_axial, rtol=0.01)
    assert (drawn.lost == 0).all()


@pytest.mark.skipif(not VALUES.exists(), reason="reference values are not here")
def test_near_the_frontier_the_engine_draws_what_the_reference_draws():
    """Tolerances are five standard errors of the difference of two runs of 200 000 draws: of u 1, of the median 1.8, of
    half an interval 2.7 times u / sqrt(draws that are left); of the lost fraction 0.0016.
    """
    rig, published = published_rig(), json.loads(VALUES.read_text())["monte_carlo_cone_D0.5_L1"]
    tangent, draws = tangent_azimuth(rig), 200_000
    for key, there in published.items():
        u, v, branch = wall_pixel(rig, tangent + np.radians(float(key.removeprefix("mc_"))))
        assert branch == (there["root"] == "far")
        first = measure(rig, u, v, u_pixel=1.0, branch=branch)
        if first.status[0] == Status.OK:  # first order does not speak of grazing rays
            assert first.u_radius[0] == pytest.approx(there["km"], rel=1e-3), key
        drawn = monte_carlo(rig, u, v, u_pixel=1.0, branch=branch, draws=draws, rng=np.random.default_rng(4))
        error = 5 * there["sd"] / np.sqrt(draws * (1 - there["no_solution"]))
        low, high = drawn.radius.symmetric[0]
        assert drawn.lost[0] == pytest.approx(there["no_solution"], abs=0.008), key
        assert drawn.radius.u[0] == pytest.approx(there["sd"], abs=error), key
        assert (high - low) / 2 == pytest.approx(there["half95"], abs=2.7 * error), key
        assert drawn.radius.median[0] - 1 == pytest.approx(there["median_bias"], abs=1.8 * error), key


def test_the_same_generator_gives_the_same_bytes_whatever_the_threads():
    rig, laser, size = random_rig(np.random.default_rng(5), "cone")
    u, v = random_pixels(np.random.default_rng(6), 37)
    one, three = (
        monte_carlo(
            rig,
            u,
            v,
            u_pixel=0.5,
            draws=1001,
            rng=np.random.default_rng(7),
            laser=laser,
            prior_radius=size,
            threads=threads,
            keep=True,
        )
        for threads in (1, 3)
    )
    assert one.radius_draws.tobytes() == three.radius_draws.tobytes()
    assert one.axial.shortest.tobytes() == three.axial.shortest.tobytes()


def test_draws_that_are_kept_tell_the_covariance_between_points():
    """Two points of a plane of uncertain baseline move together; their pixels' noise does not."""
    camera = Camera(800, 600, Lens("equidistant", 300.0, 300.0), (399.5, 299.5))
    covariance = Covariance.independent({"laser.baseline": 1e-3})
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(0.2)),), covariance=covariance)
    u, v = np.array([600.0, 250.0]), np.array([200.0, 450.0])
    first = measure(rig, u, v, u_pixel=0.3)
    drawn = monte_carlo(rig, u, v, u_pixel=0.3, draws=200_000, rng=np.random.default_rng(8), keep=True)
    wanted = np.outer(first.u_radius_common, first.u_radius_common) + np.diag(first.u_radius_independent**2)
    assert np.allclose(np.cov(drawn.radius_draws), wanted, rtol=0.02)


def test_limits_of_a_rectangular_baseline_are_the_limits_of_the_drawn_radii():
    camera = Camera(800, 600, Lens("perspective", 300.0, 300.0), (399.5, 299.5))
    covariance = Covariance.independent(
        {"laser.baseline": 1e-3 / np.sqrt(3)}, distributions={"laser.baseline": "rectangular"}
    )
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(0.2)),), covariance=covariance)
    u, v = np.array([600.0]), np.array([299.5])
    radius = measure(rig, u, v, u_pixel=0.0).radius[0]
    drawn = monte_carlo(rig, u, v, u_pixel=0.0, draws=100_000, rng=np.random.default_rng(9), keep=True)
    limits = radius * (1 + np.array([-1, 1]) * 1e-3 / 0.2)
    assert drawn.radius_draws.min() == pytest.approx(limits[0], rel=1e-6)
    assert drawn.radius_draws.max() == pytest.approx(limits[1], rel=1e-6)
    assert drawn.radius.shortest[0] == pytest.approx(radius + np.array([-0.95, 0.95]) * (limits[1] - radius), rel=1e-3)


def test_a_pixel_that_never_meets_the_light_has_no_values_and_is_lost_altogether():
    rig = published_rig()
    drawn = monte_carlo(
        rig, [np.nan, 60.0], [100.0, 60.0], u_pixel=1.0, draws=50, rng=np.random.default_rng(1), branch=0
    )
    assert drawn.lost.tolist() == [1.0, 1.0]
    assert np.isnan(drawn.radius.u).all()
    assert np.isnan(drawn.radius.shortest).all()


def test_one_draw_is_refused():
    with pytest.raises(InputError, match="at least 2 draws"):
        monte_carlo(published_rig(), [1.0], [1.0], u_pixel=1.0, draws=1, rng=np.random.default_rng(1), branch=0)

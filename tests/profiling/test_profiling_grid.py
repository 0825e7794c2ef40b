"""From rays to clock positions: no shift, no smeared edge, and the noise that neighbours share."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import Job, measure_image
from calibore.profiling._grid import grid_ring
from calibore.profiling._search import find_line, search_region
from calibore.profiling._take import place_on_wall
from calibore.rigs import Laser, Rig, project_ring
from calibore.simulation import LineLight, PipeWall, Rail, Sensor, lit_line, photograph, random_pose, true_ring
from calibore.status import Status
from calibore.uncertainty import Covariance

RADIUS = 0.15


def rig(**laser):
    camera = Camera(640, 480, Lens("equidistant", 420.0, 240.0), (320.0, 240.0))
    uncertainty = Covariance.independent({"laser.baseline": 1e-4})
    return Rig("perpendicular-plane", camera, (Laser(Plane(0.3, **laser), "red"),), covariance=uncertainty)


def picture(wall, pose_seed=None, sensor=None):
    rng = np.random.default_rng(3)
    here = rig()
    pose = random_pose(np.random.default_rng(pose_seed), here, RADIUS)
    sensor = sensor or Sensor.perfect(bits=8)
    lit = lit_line(here, wall, pipe_from_rig=pose, line=LineLight(), psf_sigma=sensor.psf_sigma)
    image = photograph(lit, here, line=LineLight(), sensor=sensor, rng=rng, speckle_rng=rng)
    return here, image, true_ring(lit, here, wall, pipe_from_rig=pose, line=LineLight())


@pytest.mark.parametrize("seed", range(4))
def test_an_off_centre_ring_is_not_shifted_in_clock(seed):
    here, image, truth = picture(PipeWall(RADIUS), pose_seed=seed)
    ring = measure_image(image, Job.of(here, RADIUS))
    # 4 % off-centre the radius changes by 6 mm per rad: a shift of a tenth of a step would be 0.01 mm everywhere
    error = ring.radius - truth.radius
    sideways = np.gradient(truth.radius, truth.clock)
    assert abs(np.polyfit(sideways, error, 1)[0]) < 0.1 * 2 * np.pi / 400
    assert np.std(error) < 2e-5


def test_an_edge_stays_an_edge():
    wall = PipeWall(RADIUS, (Rail(0.01, 0.03, edge=0.0005),))
    here, image, truth = picture(wall, pose_seed=1)
    ring = measure_image(image, Job.of(here, RADIUS))
    on_rail, off_rail = np.nanmin(truth.radius) + 0.002, np.nanmax(truth.radius) - 0.013
    between = (ring.radius > on_rail + 0.002) & (ring.radius < max(off_rail, RADIUS * 0.955))
    assert between.sum() <= 4


def test_a_stated_line_uncertainty_replaces_the_observed_one():
    here, image, _ = picture(PipeWall(RADIUS), pose_seed=1)
    search = search_region(here, RADIUS, inner=0.5, outer=1.5)
    take = place_on_wall(find_line(image, here, search, channel="red", estimator="zero-crossing"), here)
    stated = grid_ring(take, here.covariance, stripe=1.0)
    per_pixel = np.abs(np.median(take.along))
    np.testing.assert_allclose(stated.u, per_pixel, rtol=0.2)
    np.testing.assert_allclose(grid_ring(take, here.covariance, stripe=2.0).u, 2 * stated.u, rtol=1e-12)


def test_the_common_mode_of_the_baseline_is_a_change_of_scale():
    here, image, _ = picture(PipeWall(RADIUS), pose_seed=1)
    ring = measure_image(image, Job.of(here, RADIUS))
    # R = baseline tan(zenith): relative changes are equal; within a step the radius varies by 1e-3 of itself
    expected = ring.radius * 1e-4 / 0.3
    np.testing.assert_allclose(np.abs(ring.modes[0]), expected, rtol=1e-3)


def test_the_mode_at_fixed_clock_is_what_happens_when_the_rig_file_changes():
    here, image, _ = picture(PipeWall(RADIUS), pose_seed=2)
    moved = 0.4
    covariance = Covariance.independent({"camera.principal_point_u": moved})
    search = search_region(here, RADIUS, inner=0.5, outer=1.5)
    u, v = here.camera.principal_point
    rings = []
    for principal_point in ((u, v), (u + moved, v)):
        other = replace(here, camera=replace(here.camera, principal_point=principal_point))
        take = place_on_wall(find_line(image, other, search, channel="red", estimator="zero-crossing"), other)
        rings.append(grid_ring(take, covariance, stripe=None))
    change, mode = rings[1].radius - rings[0].radius, rings[0].modes[0]
    # rays change their clock step, so that the discretisation of the noise-free picture differs a little
    assert min(np.abs(change - mode).max(), np.abs(change + mode).max()) < 0.08 * np.abs(mode).max()


def test_the_search_region_holds_every_ring_it_is_asked_to():
    here = rig(tilt_x=0.05, tilt_y=-0.03)
    search = search_region(here, RADIUS, inner=0.6, outer=1.3)
    for factor in (0.6, 1.0, 1.3):
        _, u, v = project_ring(here, factor * RADIUS, 360)
        distance = np.hypot(u - search.centre[0], v - search.centre[1])
        assert search.inner - 1e-9 <= distance.min()
        assert distance.max() <= search.outer + 1


def test_a_missing_arc_is_missing_and_says_why():
    shadow = LineLight(shadows=((1.0, 0.3),))
    here = rig()
    pose = random_pose(np.random.default_rng(5), here, RADIUS)
    rng = np.random.default_rng(6)
    lit = lit_line(here, PipeWall(RADIUS), pipe_from_rig=pose, line=shadow, psf_sigma=0.9)
    ring = measure_image(photograph(lit, here, line=shadow, sensor=Sensor(), rng=rng), Job.of(here, RADIUS))
    inside = np.abs(ring.clock - 1.0) < 0.13
    assert np.isnan(ring.radius[inside]).all()
    assert (ring.status[inside] >= Status.NO_PEAK).all()
    assert np.isfinite(ring.radius[np.abs(np.mod(ring.clock - 1.0 + np.pi, 2 * np.pi) - np.pi) > 0.18]).all()

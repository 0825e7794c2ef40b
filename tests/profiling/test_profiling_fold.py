"""Where rays touch a cone: the branch is followed through, and what cannot be measured is said, not guessed."""

import numpy as np
import pytest

from calibore.lasers import Cone, MeetingFlag
from calibore.optics import Camera, Lens
from calibore.profiling._fold import MEASURABLE, enlargement, triangulate_ring
from calibore.profiling._smoothing import REACH, local_scatter, smoothed_line
from calibore.rigs import Laser, Rig, margin, meetings_of, project_ring
from calibore.status import Status
from calibore.stripe import NoiseModel, Stripe

RADIUS, RAYS, NOISE = 0.15, 1500, 0.2
LINE_GRAIN = 3
"""Rays that share their noise."""


def rig(seed):
    rng = np.random.default_rng(seed)
    baseline, projection, clock = RADIUS * rng.uniform(0.3, 0.7), RADIUS * rng.uniform(1, 2.2), rng.uniform(0, 6.28)
    camera = Camera(1024, 768, Lens("sine-law", 570.0, 384.0), (512.0, 384.0))
    return Rig("single-cone", camera, (Laser(Cone.for_ring(baseline, projection, RADIUS, clock=clock), "red"),))


def stripe(rig, rng, *, noise, radius=None):
    """The line on a wall of `radius` (n,) at n clocks, a ray at each, with `noise` px that neighbours share."""
    clock, u, v = project_ring(rig, RADIUS if radius is None else radius, RAYS)
    centre = (512.0, 384.0)
    outwards = np.stack([u - centre[0], v - centre[1]], axis=1)
    direction = outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    white = rng.standard_normal(RAYS + LINE_GRAIN - 1)
    off = noise * np.convolve(white, np.ones(LINE_GRAIN), "valid") / np.sqrt(LINE_GRAIN)
    shared = 1 - np.arange(1, LINE_GRAIN) / LINE_GRAIN
    nothing, u_position = np.zeros(RAYS), np.full(RAYS, max(noise, 1e-6))
    status, (du, dv) = np.full(RAYS, Status.OK, dtype=np.uint8), off * direction.T
    line = Stripe(u + du, v + dv, direction, u_position, status, nothing, shared, NoiseModel(), 1.0, centre)
    return clock, line


def wavy(seed):
    """A wall that is no circle: an oval, a dent up to 8 % deep anywhere."""
    rng = np.random.default_rng(seed)
    clock = np.arange(RAYS) * (2 * np.pi / RAYS)
    away = np.angle(np.exp(1j * (clock - rng.uniform(0, 2 * np.pi))))
    oval = rng.uniform(0, 0.02) * np.cos(2 * (clock - rng.uniform(0, np.pi)))
    return RADIUS * (1 + oval - rng.uniform(0, 0.08) * np.exp(-((away / 0.15) ** 2)))


@pytest.mark.parametrize("seed", range(20))
def test_the_branch_is_followed_through_both_folds_past_any_dent(seed):
    here, radius = rig(seed), wavy(seed)
    _, line = stripe(here, np.random.default_rng(seed), noise=0.0, radius=radius)
    ring = triangulate_ring(line, here, laser=0, prior_radius=RADIUS).points
    valued = ring.status == Status.OK
    # by geometry alone rays that meet the cone at less than 0.6 degrees are left out: 2 to 7 % of a ring
    assert valued.mean() > 0.9
    flags = meetings_of(here, line.u, line.v).flags_of(ring.branch)[valued]
    assert set(flags & (MeetingFlag.NEAR | MeetingFlag.FAR)) == {MeetingFlag.NEAR, MeetingFlag.FAR}
    np.testing.assert_allclose(ring.radius[valued], radius[valued], rtol=0.01)


def test_points_of_small_margin_are_grazing_and_those_of_large_margin_are_not():
    small, large = [], []
    for seed in range(24):
        here = rig(seed)
        _, line = stripe(here, np.random.default_rng(seed), noise=NOISE)
        _, u, v = project_ring(here, RADIUS, RAYS)
        ring = triangulate_ring(line, here, laser=0, prior_radius=RADIUS).points
        u_smooth = NOISE * smoothed_line(line).smaller
        m = margin(here, u, v, branch=ring.branch, u_pixel=u_smooth, direction=line.direction)
        grazing = ring.status == Status.GRAZING
        assert set(ring.status) == {Status.OK, Status.GRAZING}
        assert np.isnan(ring.radius[grazing]).all()
        small.append(grazing[m < 0.1])
        steep = ((meetings_of(here, u, v).flags & MeetingFlag.GRAZING) == 0).all(axis=0)
        large.append(grazing[(m > MEASURABLE + 4) & steep])
    # the margin is seen with a noise of 1, by definition: 0 is seen above 1 once in six
    assert np.concatenate(small).size > 100
    assert np.concatenate(small).mean() > 0.7
    assert np.concatenate(large).mean() < 0.005


def test_what_is_kept_near_the_fold_is_within_its_uncertainty_on_average_and_not_biased():
    z, size = [], []
    for seed in range(60):
        here = rig(seed)
        _, line = stripe(here, np.random.default_rng([9, seed]), noise=NOISE)
        ring = triangulate_ring(line, here, laser=0, prior_radius=RADIUS)
        along = np.einsum("nk,nk->n", ring.points.radius_sensitivities.pixel, line.direction)
        u = np.abs(along) * ring.u_position * ring.enlargement
        near = (np.abs(along) > 0.01 * RADIUS / NOISE) & np.isfinite(u)
        z.append(((ring.points.radius - RADIUS) / u)[near])
        size.append(near.sum())
    assert np.mean(size) > 30
    joined = np.concatenate(z)
    # neighbours share their smoothed noise: four folds' worth of some ten independent points per rig, 60 rigs
    assert abs(np.mean(joined)) < 0.35
    assert 0.90 <= np.mean(np.abs(joined) <= 1.96) <= 0.995


def test_uncertainty_near_the_fold_is_that_of_first_order_from_a_margin_of_four_on():
    m = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 8.0, 25.0, 1e6, np.inf, np.nan])
    found = enlargement(m)
    assert (found[:3] > 1.3).all()
    # without the chance of a wrong branch, by quadrature: 1.257, 1.111, 1.020
    np.testing.assert_allclose(found[3:6], [1.257, 1.111, 1.020], atol=0.15)
    assert (np.diff(found[2:8]) <= 1e-12).all()
    np.testing.assert_array_equal(found[-3:], 1.0)


def test_smoothing_keeps_a_slope_and_an_edge_and_takes_noise_as_it_says():
    here, rng = rig(3), np.random.default_rng(5)
    _, clean = stripe(here, rng, noise=0.0)
    step = np.where(np.arange(RAYS) < RAYS // 2, 0.0, 6.0)
    shift = step + 0.05 * np.minimum(np.arange(RAYS), RAYS - np.arange(RAYS))
    du, dv = shift * clean.direction.T
    sloped = Stripe(clean.u + du, clean.v + dv, *_rest(clean))
    away = np.abs(np.arange(RAYS) - RAYS // 2) > 2 * REACH
    away &= np.minimum(np.arange(RAYS), RAYS - np.arange(RAYS)) > 2 * REACH
    assert np.abs(smoothed_line(sloped).off[away]).max() < 0.01
    assert np.abs(smoothed_line(sloped).off).max() < 1.5  # an edge of 6 px is not smeared
    noisy = [smoothed_line(stripe(here, rng, noise=NOISE)[1]) for _ in range(20)]
    scatter = np.std([np.hypot(line.u - 512, line.v - 384) for line in noisy], axis=0)
    # `smaller` is stated as the grid takes it, which averages four rays of a step: a mean factor of 0.8
    assert 0.6 < np.mean(scatter) / (NOISE * noisy[0].smaller) < 1.0


def _rest(line):
    return (
        line.direction,
        line.u_position,
        line.status,
        line.height,
        line.correlation,
        line.noise,
        line.scale,
        line.centre,
    )


def test_noise_that_differs_round_the_ring_is_found_where_it_is():
    rng = np.random.default_rng(6)
    azimuth = np.arange(RAYS) * (2 * np.pi / RAYS)
    true = 0.2 * (1.5 + np.cos(azimuth))
    found = [local_scatter(250 + true * rng.standard_normal(RAYS), np.full(RAYS, 0.2), lag=8) for _ in range(30)]
    np.testing.assert_allclose(np.mean(found, axis=0), true / 0.2, rtol=0.12)
    assert np.mean(np.std(found, axis=0) / (true / 0.2)) < 0.1
    edges = 250 + np.where(azimuth < 3, 0.0, 40.0) + 0.2 * rng.standard_normal(RAYS)
    assert np.abs(local_scatter(edges, np.full(RAYS, 0.2), lag=8) - 1).max() < 0.4


def test_a_line_of_a_few_peaks_has_the_noise_it_states():
    position = np.where(np.arange(RAYS) < 30, 250.0, np.nan)
    np.testing.assert_array_equal(local_scatter(position, np.full(RAYS, 0.2), lag=8), 1.0)

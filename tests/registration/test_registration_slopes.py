"""Slopes of a measured wall: what lies beside an edge or a gap has the slope of its own side."""

import numpy as np

from calibore.registration._surface import Surface
from calibore.scans import Profile

STEPS, RINGS = 400, 5
CLOCK = np.arange(STEPS) * 2 * np.pi / STEPS


def wall(radius, *, u=1e-4):
    shape = (RINGS, STEPS)
    radius = np.broadcast_to(radius, shape).copy()
    axial = np.arange(RINGS) * 0.01
    status = np.where(np.isnan(radius), 3, 0).astype(np.uint8)
    places = np.broadcast_to(axial[:, None], shape).copy()
    return Profile(axial, CLOCK, radius, places, np.full(shape, u), np.zeros((0, *shape)), np.zeros((RINGS, 1)), status)


def test_a_gap_with_an_edge_in_it_gives_no_slope_to_what_lies_beside_it():
    # a rail's top, 20 mm nearer, from position 190 on; the four positions before it were not measured
    radius = np.full(STEPS, 0.15)
    radius[190:] = 0.13
    radius[186:190] = np.nan
    by_clock, _ = Surface(wall(radius)).clock_slopes
    assert np.abs(by_clock[:, 180:186]).max() < 1e-3
    assert np.abs(by_clock[:, 190:200]).max() < 1e-3


def test_a_gap_on_a_slope_leaves_it_a_slope():
    radius = 0.15 + 0.002 * np.sin(2 * CLOCK)
    radius[100:104] = np.nan
    by_clock, _ = Surface(wall(radius, u=2e-6)).clock_slopes
    true = 0.004 * np.cos(2 * CLOCK)
    np.testing.assert_allclose(by_clock[:, 95:100], np.broadcast_to(true[95:100], (RINGS, 5)), atol=2e-4)

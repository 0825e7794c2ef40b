"""A ball touches a sloping wall beside the line it is pushed along; the wall is found where the pin points."""

import numpy as np
import pytest
from tactile_walls import INCH, NOMINAL, TURN, Pipe, random_pipe, scanned, touched

from calibore.profiling._tactile._neighbours import Grid
from calibore.profiling._tactile._tip import touch

RHO = INCH / 16
NOISE = 0.0006 * INCH


def contact_of(reading, clock, axial, *, tip_radius=RHO, noise=NOISE):
    good = np.isfinite(reading)
    return touch(reading, Grid(clock, axial, tip_radius), good=good, noise=noise, usual=noise)


def test_a_round_pipe_about_the_axis_needs_no_correction():
    clock, axial = np.arange(400) * TURN / 400, np.arange(5) * 0.1 * INCH
    reading = np.full((5, 400), NOMINAL)
    found = contact_of(reading, clock, axial)
    assert np.allclose(found.radius, NOMINAL, atol=1e-12)
    assert np.allclose(found.touch_radius, NOMINAL, atol=1e-12)
    assert np.allclose(found.u, NOISE)


@pytest.mark.parametrize("seed", range(2))
def test_without_noise_the_wall_of_a_dented_pipe_is_found_though_the_ball_touches_beside(seed):
    """What is left is the curvature over a step: micrometres where the ball is off by hundreds."""
    rng = np.random.default_rng(seed)
    pipe = Pipe(((1, 0.2 * INCH, 1.0),), random_pipe(rng, sharp=False).parts, 0.3)
    clock, axial = np.arange(400) * TURN / 400, (20 + np.arange(12)) * 0.05 * INCH
    wall = pipe.radius(*np.meshgrid(clock, axial))
    reading = touched(pipe, clock, axial, tip_radius=2 * RHO, fine=35)
    found = contact_of(reading, clock, axial, tip_radius=2 * RHO)
    assert np.max(np.abs(reading - wall)) > 100e-6
    assert np.max(np.abs(found.radius - wall)) < 15e-6


def test_the_touching_points_lie_on_the_wall_and_one_tip_radius_from_the_ball():
    pipe = Pipe((), random_pipe(np.random.default_rng(5), sharp=False).parts, 0.2)
    clock, axial = np.arange(400) * TURN / 400, (10 + np.arange(12)) * 0.1 * INCH
    reading = touched(pipe, clock, axial, tip_radius=RHO, fine=35)
    found = contact_of(reading, clock, axial)
    assert np.max(np.abs(pipe.radius(found.touch_clock, found.touch_axial) - found.touch_radius)) < 15e-6
    centre = np.stack([reading - RHO, 0 * reading, np.broadcast_to(axial[:, None], reading.shape)])
    aside = found.touch_clock - clock
    point = np.stack([found.touch_radius * np.cos(aside), found.touch_radius * np.sin(aside), found.touch_axial])
    assert np.allclose(np.linalg.norm(point - centre, axis=0), RHO, rtol=1e-9)
    assert np.max(np.abs(found.touch_axial - axial[:, None])) > 0.1 * RHO


def test_a_slope_is_touched_on_its_shallow_side():
    clock, axial = np.arange(400) * TURN / 400, np.arange(5) * 0.1 * INCH
    deeper_along = NOMINAL + 0.3 * axial[:, None] + 0 * clock
    found = contact_of(deeper_along, clock, axial)
    assert (found.touch_axial < axial[:, None]).all()
    assert np.allclose(found.radius - deeper_along, RHO * (np.sqrt(1.09) - 1), atol=1e-9)


def test_rings_taken_on_the_way_back_tell_the_same():
    pipe = Pipe((), random_pipe(np.random.default_rng(6), sharp=False).parts, 0.2)
    clock, axial = np.arange(400) * TURN / 400, np.arange(9) * 0.1 * INCH
    reading = touched(pipe, clock, axial, tip_radius=RHO)
    there, back = contact_of(reading, clock, axial), contact_of(reading[::-1], clock, axial[::-1])
    for name in ("radius", "u", "touch_radius", "touch_clock", "touch_axial"):
        assert np.allclose(getattr(there, name), getattr(back, name)[::-1], rtol=1e-12, atol=1e-15), name


def test_intervals_hold_the_wall_on_slopes_and_off_them():
    """Random walls with dents, cones, rails, openings: 95 % intervals of good points, each kind of place apart."""
    inside = {"level": [], "sloping": []}
    for seed in range(4):
        rng = np.random.default_rng(100 + seed)
        made = scanned(random_pipe(rng, sharp=False), rng, stick=0.0, rings=30)
        found = contact_of(made.reading, made.clock, made.axial)
        off = np.abs(found.radius - made.wall) <= 1.96 * found.u
        moved = made.wall - made.contact > 0.1 * NOISE
        inside["sloping"].append(off[moved])
        inside["level"].append(off[~moved])
    for name, values in inside.items():
        share = np.concatenate(values)
        assert share.size > 3000
        assert 0.93 < share.mean() < 0.97, name


def test_a_reading_with_nothing_beside_it_tells_no_wall():
    clock, axial = np.arange(400) * TURN / 400, np.arange(5) * 0.1 * INCH
    reading = np.full((5, 400), NOMINAL)
    reading[:, 95:100] = reading[:, 101:106] = np.nan
    found = contact_of(reading, clock, axial)
    assert np.isnan(found.radius[:, 100]).all()
    assert np.isfinite(found.radius[:, 90:94]).all()


def test_one_ring_alone_is_taken_as_straight_along_the_pipe():
    clock = np.arange(400) * TURN / 400
    reading = NOMINAL * (1 + 0.01 * np.cos(2 * clock))[None]
    assert np.isfinite(contact_of(reading, clock, np.zeros(1)).radius).all()

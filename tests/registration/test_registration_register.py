"""Two profiles of one pipe come into one frame by themselves, and what is said of the motion holds."""

from dataclasses import replace

import numpy as np
import pytest
from registration_walls import Wall, random_motion, random_wall, seen

from calibore.errors import InputError
from calibore.registration import Motion, register, rotated

STATION = 0.005


def _pair(seed, *, bumps=6, per_ring=None):
    """A dense reference, a sparse scan that lies somewhere else, and the true motion."""
    rng = np.random.default_rng(seed)
    wall, motion = random_wall(rng, bumps=bumps), random_motion(rng, station=STATION)
    reference = seen(wall, np.arange(0, 0.25, STATION), rng, u=3e-5, modes=(2e-4,))
    moving = seen(wall, np.arange(0.02, 0.24, 0.022), rng, motion=motion, u=8e-5, modes=(5e-4,))
    return moving, reference, motion


def _standardised(found, motion):
    true = motion.about(found.motion.pivot)
    return np.array([(getattr(found.motion, name) - getattr(true, name)) / found.u(name) for name in found.names])


@pytest.mark.slow
def test_the_motion_is_found_from_anywhere_and_its_intervals_hold_it():
    z = []
    for seed in range(16):
        moving, reference, motion = _pair(seed)
        found = register(moving, reference)
        assert not found.untold
        assert found.u("roll") < np.radians(0.1)
        assert found.u("axial") < 0.05 * STATION
        z.append(_standardised(found, motion))
    z = np.array(z)
    # 96 values; 40 pairs gave 97 % within 1.96 u, scatter 0.97
    assert np.mean(np.abs(z) < 1.96) > 0.88
    assert 0.75 < np.sqrt(np.mean(z**2)) < 1.25
    assert np.abs(z).max() < 4


def test_a_change_of_the_wall_does_not_move_the_motion():
    rng = np.random.default_rng(3)
    wall, motion = random_wall(rng), random_motion(rng, station=STATION)
    dent = np.array([[0.12, 2.0, 0.004, 0.02, 0.2], [0.2, 4.0, 0.003, 0.01, 0.1]])
    changed = replace(wall, bumps=np.concatenate([wall.bumps, dent]))
    reference = seen(wall, np.arange(0, 0.25, STATION), rng, u=3e-5)
    moving = seen(changed, np.arange(0.02, 0.24, 0.022), rng, motion=motion, u=8e-5)
    moving.radius[:, 100:140] = np.nan
    found = register(moving, reference)
    assert np.abs(_standardised(found, motion)).max() < 3.5


def test_a_round_pipe_does_not_tell_its_roll_nor_a_straight_one_its_axial_shift():
    rng = np.random.default_rng(5)
    wall = Wall(0.15, np.array([[2.0, 0.0, 0.0]]), np.zeros((0, 5)))
    reference, moving = (seen(wall, np.arange(0, 0.2, 0.01), rng, u=5e-5) for _ in range(2))
    found = register(moving, reference, search=False)
    assert {"roll", "axial"} <= set(found.untold)
    assert found.u("roll") > np.radians(4)
    assert "shift_x" not in found.untold
    assert abs(found.motion.shift_x) < 4 * found.u("shift_x")


def _of_little_ovality(ovality, seed):
    """Error and standard uncertainty [rad] of the roll of a nearly round pipe, and what is not told."""
    rng = np.random.default_rng([9, seed])
    wall = Wall(0.15, np.array([[2.0, 0.15 * ovality, rng.uniform(0, 3)]]), np.zeros((0, 5)))
    motion = Motion(roll=rng.uniform(-0.1, 0.1))
    reference = seen(wall, np.arange(0, 0.2, 0.01), rng, u=5e-5)
    moving = seen(wall, np.arange(0, 0.2, 0.02), rng, motion=motion, u=5e-5)
    start = Motion(roll=motion.roll + rng.uniform(-0.05, 0.05))
    found = register(moving, reference, free=("roll", "shift_x", "shift_y"), start=start, search=False)
    return found.motion.roll - motion.roll, found.u("roll"), found.untold


@pytest.mark.parametrize("ovality", [4e-4, 2e-3])
def test_little_ovality_tells_the_roll_as_well_as_is_said(ovality):
    """40 pairs each: scatter 0.67 and 0.8 of u at noise of 0.03 % of the radius."""
    cases = [_of_little_ovality(ovality, seed) for seed in range(10)]
    z = np.array([error / u for error, u, _ in cases])
    assert 0.3 < np.sqrt(np.mean(z**2)) < 1.4
    assert np.median([u for _, u, _ in cases]) < 12e-6 / ovality


def test_ovality_below_the_noise_does_not_tell_the_roll():
    assert _of_little_ovality(1e-4, 0)[2] == ("roll",)


def test_rings_that_wander_are_followed():
    rng = np.random.default_rng(8)
    wall = random_wall(rng, bumps=14)
    axial = np.arange(0.02, 0.24, 0.01)
    walk = np.cumsum(rng.normal(0, [np.radians(0.08), 2e-4, 2e-4], (axial.size, 3)), axis=0)
    walk -= walk.mean(axis=0)
    rings = [
        seen(wall, axial[i : i + 1], rng, motion=Motion(roll=a, shift_x=x, shift_y=y), u=8e-5)
        for i, (a, x, y) in enumerate(walk)
    ]
    moving = replace(
        rings[0],
        axial=axial,
        **{
            name: np.concatenate([getattr(ring, name) for ring in rings], axis=axis)
            for name, axis in (
                ("radius", 0),
                ("axial_position", 0),
                ("u_independent", 0),
                ("common_mode", 1),
                ("correlation", 0),
                ("status", 0),
            )
        },
    )
    reference = seen(wall, np.arange(0, 0.25, STATION), rng, u=3e-5)
    found = register(moving, reference, per_ring=True, free=("roll", "shift_x", "shift_y", "axial"))
    assert found.drift is not None
    assert found.u_drift is not None
    motion = np.array([found.motion.roll, found.motion.shift_x, found.motion.shift_y])
    assert np.abs(found.drift + motion - walk).max() < [0.004, 5e-5, 5e-5][0]
    z = (found.drift + motion - walk) / np.maximum(found.u_drift, 1e-9)
    assert np.sqrt(np.mean(z**2)) < 1.5
    rigid = register(moving, reference, free=("roll", "shift_x", "shift_y", "axial"))
    assert rigid.scatter > 1.3 * found.scatter


def test_manual_values_are_kept_and_only_the_rest_is_solved():
    moving, reference, motion = _pair(2)
    manual = motion.about(0.13)
    found = register(moving, reference, start=manual, free=("axial",), search=False)
    assert found.motion.about(0.13).roll == manual.roll
    assert found.names == ("axial",)
    assert abs(_standardised(found, motion)[0]) < 4


def test_scale_is_told_apart_from_the_motion_where_it_is_free():
    rng = np.random.default_rng(11)
    wall = random_wall(rng)
    motion = Motion(roll=0.05, shift_x=1e-3, scale=1.004)
    reference = seen(wall, np.arange(0, 0.25, STATION), rng, u=3e-5)
    moving = seen(wall, np.arange(0.02, 0.24, 0.022), rng, motion=motion, u=8e-5)
    found = register(moving, reference, free=("roll", "shift_x", "shift_y", "axial", "scale"))
    assert found.motion.scale == pytest.approx(1.004, abs=4 * found.u("scale"))
    assert found.u("scale") < 1e-4


def test_pipes_that_do_not_overlap_are_refused():
    rng = np.random.default_rng(1)
    wall = random_wall(rng)
    with pytest.raises(InputError, match="do not overlap along the pipe: one covers 500 to 550 mm"):
        register(seen(wall, np.arange(0.5, 0.55, 0.01), rng), seen(wall, np.arange(0, 0.1, 0.01), rng))


def test_the_fractional_turn_of_the_dissertation_shrinks_noise_where_its_fraction_is_a_half():
    noise = np.random.default_rng(0).normal(size=200_000)
    assert rotated(noise, 3.5).std() == pytest.approx(np.sqrt(0.5), abs=5e-3)
    np.testing.assert_allclose(rotated(noise, -2), np.roll(noise, -2))


@pytest.mark.parametrize("seed", range(4))
def test_slopes_of_a_motion_are_its_differences(seed):
    rng = np.random.default_rng(seed)
    motion = Motion(*rng.normal(0, [0.1, 0.01, 0.01, 0.01, 1e-3, 2e-4, 2e-4]), scale=1.01, pivot=0.3)
    points = rng.normal(0, 0.2, (50, 3))
    moved, slopes = motion.apply_with_slopes(points)
    np.testing.assert_allclose(moved, motion.apply(points), atol=1e-15)
    np.testing.assert_allclose(motion.about(0.1).apply(points), moved, atol=1e-5)
    for k, name in enumerate(Motion.names):
        step = 1e-6
        up, down = (replace(motion, **{name: getattr(motion, name) + way * step}).apply(points) for way in (1, -1))
        np.testing.assert_allclose(slopes[:, :, k], (up - down) / (2 * step), atol=2e-4)

"""Rays aimed everywhere meet the lit nappe of any cone where it is, and nowhere else."""

import warnings

import numpy as np
import pytest
from rays_everywhere import rays, surfaces

from calibore.errors import InputError
from calibore.lasers import GRAZING_SINE, Cone, MeetingFlag

CONES = surfaces("cone", 40)
DEG = np.pi / 180


def solid(cone, points):
    """Positive inside the convex solid that the light bounds."""
    return np.sign(np.cos(cone.half_angle)) * cone.value(points)


def test_every_meeting_lies_on_the_lit_nappe():
    for cone in CONES:
        origins, directions = rays(np.random.default_rng(2))
        meetings = cone.meet(origins, directions)
        for distance, exists in zip(meetings.distance, meetings.flags != 0, strict=True):
            points = origins[exists] + distance[exists, None] * directions[exists]
            arms = points - cone.apex
            size = np.linalg.norm(arms, axis=1) + np.linalg.norm(origins[exists] - cone.apex, axis=1)
            assert (np.abs(cone.value(points)) < 1e-9 * size).all()
            assert (arms @ cone.axis * np.cos(cone.half_angle) > 0).all()


def test_admissible_meetings_are_ahead_and_not_grazing_and_the_ray_is_aimed_everywhere():
    shares = []
    for cone in CONES:
        origins, directions = rays(np.random.default_rng(3))
        meetings = cone.meet(origins, directions)
        good = meetings.admissible
        assert (meetings.distance[good] > 0).all()
        for distance, kept in zip(meetings.distance, good, strict=True):
            gradient = cone.gradient(origins[kept] + distance[kept, None] * directions[kept])
            sine = np.einsum("ni,ni->n", gradient, directions[kept]) / np.linalg.norm(gradient, axis=1)
            assert (np.abs(sine) > GRAZING_SINE * (1 - 1e-6)).all()
        shares.append(good.mean(axis=1))
    assert (np.mean(shares, axis=0) > 0.1).all()  # of rays that see the near one, of rays that see the far one


def test_near_is_where_the_ray_enters_the_solid_of_light_and_far_where_it_leaves():
    for cone in CONES:
        origins, directions = rays(np.random.default_rng(4))
        meetings = cone.meet(origins, directions)
        for distance, good, sign in zip(meetings.distance, meetings.admissible, (1, -1), strict=True):
            o, u, d = origins[good], directions[good], distance[good, None]
            step = 1e-4 * np.linalg.norm(o + d * u - cone.apex, axis=1, keepdims=True)
            assert (sign * solid(cone, o + (d - step) * u) < 0).all()
            assert (sign * solid(cone, o + (d + step) * u) > 0).all()
        both = meetings.admissible.all(axis=0)
        assert (meetings.distance[0, both] < meetings.distance[1, both]).all()


def test_the_meetings_are_all_that_dense_sampling_of_the_ray_finds():
    steps = np.linspace(0, 6, 1501)
    counts = np.zeros(3, dtype=int)
    for cone in CONES:
        origins, directions = rays(np.random.default_rng(5), 200)
        along = origins[:, None] + steps[:, None] * directions[:, None]
        inside = solid(cone, along.reshape(-1, 3)).reshape(len(origins), -1) > 0
        meetings = cone.meet(origins, directions)
        lit = (meetings.flags != 0) & (meetings.flags & MeetingFlag.BEHIND == 0) & (meetings.distance < steps[-1])
        cell = np.where(lit, np.digitize(np.where(lit, meetings.distance, 0), steps) - 1, -1)
        once = lit & (cell != cell[::-1])  # both in one cell leave no trace there
        found = np.zeros((2, len(origins), len(steps) - 1), dtype=bool)
        found[(*np.nonzero(once), cell[once])] = True
        assert np.array_equal(found[0], ~inside[:, :-1] & inside[:, 1:])
        assert np.array_equal(found[1], inside[:, :-1] & ~inside[:, 1:])
        counts += np.bincount(lit.sum(axis=0), minlength=3)
    assert (counts > 100).all()  # rays with no, one and two meetings were among them


def test_mirrored_rays_meet_the_mirrored_cone_at_the_same_distances():
    mirror = np.array([-1.0, 1.0, 1.0])
    for cone in CONES:
        other = Cone(cone.baseline, cone.aim, cone.half_angle, -cone.clock, cone.offset)
        origins, directions = rays(np.random.default_rng(6), 500)
        one, two = cone.meet(origins, directions), other.meet(origins * mirror, directions * mirror)
        assert np.array_equal(one.flags, two.flags)
        np.testing.assert_allclose(one.distance, two.distance, rtol=1e-6)


def test_a_rig_twice_as_large_has_meetings_twice_as_far():
    for cone in CONES:
        other = Cone(2 * cone.baseline, cone.aim, cone.half_angle, cone.clock, 2 * cone.offset)
        origins, directions = rays(np.random.default_rng(7), 500)
        one, two = cone.meet(origins, directions), other.meet(2 * origins, directions)
        assert np.array_equal(one.flags, two.flags)
        assert np.array_equal(2 * one.distance, two.distance, equal_nan=True)


def test_a_ray_along_a_generator_has_one_meeting_and_no_warning():
    """Cosines and lengths are exact binary fractions, so that the leading coefficient is exactly 0."""
    cone = Cone(0.0, 0.0, np.arccos(0.5), offset=1.0)
    around = np.linspace(0, 2 * np.pi, 50)
    directions = np.stack([np.sqrt(0.75) * np.cos(around), np.sqrt(0.75) * np.sin(around), np.full(50, 0.5)]).T
    tilts = np.concatenate([[0], 10.0 ** np.arange(-300, -1, 7)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for tilt in tilts:
            turned = directions + np.array([0, 0, tilt])
            turned /= np.linalg.norm(turned, axis=1, keepdims=True)
            meetings = cone.meet(np.array([0.2, 0.1, 1.5]), turned)
            assert (meetings.flags != 0).any(axis=0).all()
            cone.frontier(np.array([0.2, 0.1, 1.5]), turned)


def test_the_meeting_that_stays_moves_smoothly_where_the_ray_turns_parallel_to_a_generator():
    tilts = np.concatenate([-np.logspace(-6, -17, 30), [0], np.logspace(-17, -6, 30)])
    rng, tried = np.random.default_rng(9), np.zeros(2, dtype=int)
    for cone in CONES:
        for _ in range(20):
            across, tilt = (np.cross(cone.axis, v) for v in rng.normal(size=(2, 3)))
            generator = np.cos(cone.half_angle) * cone.axis
            generator = generator + np.sin(cone.half_angle) * across / np.linalg.norm(across)
            directions = rng.choice([-1, 1]) * generator + tilts[:, None] * tilt
            distances = cone.meet(rng.normal(size=3), directions).distance
            for branch, distance in enumerate(distances):
                if 0 < distance[len(tilts) // 2] < 10:  # the other meeting is at infinity there
                    tried[branch] += 1
                    assert np.ptp(distance) < 0.02 * (1 + distance.max())
    assert (tried > 50).all()


def test_a_ray_that_is_none_meets_nothing():
    cone = CONES[0]
    meetings = cone.meet(np.zeros(3), np.full((1, 3), np.nan))
    assert meetings.flags.dtype == np.uint8
    assert meetings.flags.tolist() == [[0], [0]]
    assert np.isnan(cone.frontier(np.zeros(3), np.full((1, 3), np.nan)).value[0]).all()


def test_the_gradient_on_the_cone_has_the_length_of_the_sine_of_its_half_angle():
    for cone in CONES:
        origins, directions = rays(np.random.default_rng(8), 500)
        meetings = cone.meet(origins, directions)
        good = meetings.admissible[0]
        points = origins[good] + meetings.distance[0, good, None] * directions[good]
        np.testing.assert_allclose(np.linalg.norm(cone.gradient(points), axis=1), np.sin(cone.half_angle), rtol=1e-8)


@pytest.mark.parametrize("clock", [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi])
def test_the_apex_stands_at_its_clock_and_a_positive_aim_inclines_towards_the_rig_axis(clock):
    cone = Cone(0.3, 10 * DEG, 30 * DEG, clock, 0.2)
    outwards = np.array([np.sin(clock), -np.cos(clock), 0])
    np.testing.assert_allclose(cone.apex, 0.3 * outwards + np.array([0, 0, 0.2]), atol=1e-15)
    assert cone.axis @ outwards == pytest.approx(-np.sin(10 * DEG))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((-0.1, 0.1, 0.5), "baseline of a cone must be 0 .coaxial. or positive, got -0.1 m"),
        ((np.inf, 0.1, 0.5), "baseline of a cone"),
        ((np.nan, 0.1, 0.5), "baseline of a cone"),
        ((0.0, 0.1, 0.5), "no pixel would tell a distance"),
        ((0.3, 90 * DEG, 0.5), "aim must lie between -90 and 90 deg, got 90 deg"),
        ((0.3, np.nan, 0.5), "aim must lie"),
        ((0.3, 0.0, 0.0), "half angle must lie between 0 and 180 deg, got 0 deg"),
        ((0.3, 0.0, np.pi), "half angle must lie"),
        ((0.3, 0.0, np.nan), "half angle must lie"),
        ((0.3, 0.0, np.pi / 2), "describe it as a plane"),
        ((0.3, -45 * DEG, 45 * DEG), r"below 90 deg, got 45 \+ 45 deg: the light would not meet the wall ahead"),
        ((0.3, 40 * DEG, 120 * DEG), "above 90 deg, got 120 - 40 deg: the light would not meet the wall behind"),
        ((0.3, 0.0, 0.5, np.nan), "Clock and offset are finite"),
        ((0.3, 0.0, 0.5, 0.0, np.inf), "Clock and offset are finite"),
    ],
)
def test_a_cone_that_lights_no_wall_is_refused_in_a_sentence(arguments, words):
    with pytest.raises(InputError, match=words):
        Cone(*arguments)

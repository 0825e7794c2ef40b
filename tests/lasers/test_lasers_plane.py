"""Rays aimed everywhere meet the plane where it is, or are flagged."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import GRAZING_SINE, MeetingFlag, Plane


def rays(rng, n=5000):
    directions = rng.normal(size=(n, 3))
    return rng.normal(size=(n, 3)) * 0.3, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def planes(n=20):
    rng = np.random.default_rng(1)
    return [Plane(rng.uniform(0.1, 2), *rng.uniform(-0.5, 0.5, 2)) for _ in range(n)]


def test_every_admissible_meeting_lies_on_the_plane_ahead_of_the_ray():
    for plane in planes():
        origins, directions = rays(np.random.default_rng(2))
        meetings = plane.meet(origins, directions)
        points = origins + meetings.distance[0][:, None] * directions
        good = meetings.admissible[0]
        assert 0.2 < good.mean() < 0.8  # aimed everywhere: many rays miss
        assert np.abs(plane.value(points[good])).max() < 1e-12 * np.abs(points[good]).max()
        assert (meetings.distance[0][good] > 0).all()


def test_every_ray_without_an_admissible_meeting_is_grazing_or_runs_away_from_the_plane():
    for plane in planes():
        origins, directions = rays(np.random.default_rng(3))
        flags = plane.meet(origins, directions).flags[0]
        normal = plane.gradient(origins)[0]
        sine = directions @ normal / np.linalg.norm(normal)
        approaching = -plane.value(origins) * sine > 0
        assert np.array_equal((flags & MeetingFlag.GRAZING) != 0, np.abs(sine) < GRAZING_SINE)
        assert np.array_equal((flags & MeetingFlag.BEHIND) != 0, ~approaching)
        assert ((flags & MeetingFlag.NEAR) != 0).all()


def test_a_ray_that_is_none_meets_nothing_and_a_parallel_one_only_grazes():
    meetings = Plane(1.0).meet(np.zeros(3), np.array([[np.nan] * 3, [1.0, 0.0, 0.0]]))
    assert meetings.flags.dtype == np.uint8
    assert meetings.flags[0].tolist() == [MeetingFlag.NONE, MeetingFlag.NEAR | MeetingFlag.GRAZING]
    assert not meetings.admissible.any()


def test_gradients_are_the_slopes_of_the_value():
    step, rng = 1e-30, np.random.default_rng(4)
    for plane in planes(5):
        points = rng.normal(size=(50, 3))
        for axis in range(3):
            moved = points + 1j * step * np.eye(3)[axis]
            assert np.allclose(plane.value(moved).imag / step, plane.gradient(points)[:, axis], atol=1e-14)
        for i, name in enumerate(plane.parameter_names):
            other = object.__new__(Plane)
            for each in plane.parameter_names:
                object.__setattr__(other, each, getattr(plane, each) + 1j * step * (each == name))
            assert np.allclose(other.value(points).imag / step, plane.parameter_gradient(points)[:, i], atol=1e-14)


@pytest.mark.parametrize("baseline", [0.0, -0.3, np.nan, np.inf])
def test_a_plane_that_is_not_ahead_of_the_camera_is_refused(baseline):
    with pytest.raises(InputError, match="baseline must be positive"):
        Plane(baseline)


def test_a_tilt_must_be_finite():
    with pytest.raises(InputError, match="finite slopes"):
        Plane(1.0, np.nan)

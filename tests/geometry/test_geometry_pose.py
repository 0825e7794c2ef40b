"""Rigid motions keep distances, compose and undo themselves."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose, clock_of


def poses(n):
    rng = np.random.default_rng(2)
    return [Pose.from_roll_pitch_yaw(*rng.uniform(-3, 3, 3), translation=rng.uniform(-5, 5, 3)) for _ in range(n)]


def test_a_pose_undone_is_the_identity_and_poses_compose():
    points = np.random.default_rng(3).normal(size=(40, 3))
    for a, b in zip(poses(20), reversed(poses(20)), strict=True):
        assert np.allclose((a @ b).apply(points), a.apply(b.apply(points)), atol=1e-12)
        assert np.allclose(a.inverse().apply(a.apply(points)), points, atol=1e-12)
        assert np.allclose((a @ a.inverse()).rotation, np.eye(3), atol=1e-14)


def test_roll_turns_the_clock_forward_pitch_lifts_the_nose_and_yaw_turns_it_right():
    rolled = Pose.from_roll_pitch_yaw(roll=0.3).apply([0.0, -1.0, 0.0])
    assert clock_of(rolled[0], rolled[1]) == pytest.approx(0.3)
    assert Pose.from_roll_pitch_yaw(pitch=0.1).apply([0.0, 0.0, 1.0])[1] == pytest.approx(-np.sin(0.1))
    assert Pose.from_roll_pitch_yaw(yaw=0.1).apply([0.0, 0.0, 1.0])[0] == pytest.approx(np.sin(0.1))


def test_roll_comes_first_then_pitch_then_yaw():
    whole = Pose.from_roll_pitch_yaw(0.4, -0.2, 0.7)
    parts = (
        Pose.from_roll_pitch_yaw(yaw=0.7) @ Pose.from_roll_pitch_yaw(pitch=-0.2) @ Pose.from_roll_pitch_yaw(roll=0.4)
    )
    assert np.allclose(whole.rotation, parts.rotation, atol=1e-15)


@pytest.mark.parametrize("rotation", [np.diag([1, 1, -1]), np.eye(3) * 1.001, np.eye(2), np.full((3, 3), np.nan)])
def test_what_is_no_rotation_is_refused(rotation):
    with pytest.raises(InputError, match="pose"):
        Pose(rotation, np.zeros(3))

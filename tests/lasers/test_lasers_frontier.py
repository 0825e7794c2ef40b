"""The frontiers of a cone fall to 0 where its meetings cease, and carry the published margins."""

import json
from pathlib import Path

import numpy as np
import pytest
from rays_everywhere import rays, surfaces

from calibore.lasers import Cone, MeetingFlag, ring_angles

PUBLISHED = Path(__file__).parents[2].parent / "shared" / "reference" / "published_values.json"
PUPIL = np.zeros(3)
TANGENT = np.radians(-1.827503591)  # azimuth from the right, y up, of the ring point that the camera sees edge-on


def test_the_first_frontier_is_positive_where_and_only_where_the_ray_meets_the_double_cone():
    for cone in surfaces("cone", 40):
        origins, directions = rays(np.random.default_rng(2))
        value = cone.frontier(origins, directions).value[0]
        exists = (cone.meet(origins, directions).flags != 0).any(axis=0)
        assert (value[exists] >= 0).all()
        mirrored = Cone(cone.baseline, cone.aim, cone.half_angle, cone.clock, cone.offset)
        object.__setattr__(mirrored, "half_angle", np.pi - cone.half_angle)  # the other nappe of the same double cone
        exists |= (mirrored.meet(origins, directions).flags != 0).any(axis=0)
        assert (value[~exists] < 0).all()


def test_a_meeting_far_away_has_a_small_frontier_of_its_own():
    """Distance x frontier stays bounded: the meeting recedes no faster than its frontier falls."""
    seen = np.zeros(2, dtype=int)
    for cone in surfaces("cone", 40):
        origins, directions = rays(np.random.default_rng(3), 20000)
        meetings, frontier = cone.meet(origins, directions), cone.frontier(origins, directions)
        size = np.linalg.norm(origins - cone.apex, axis=1)
        for branch, row in ((0, 2), (1, 1)):
            far = (meetings.flags[branch] != 0) & (meetings.distance[branch] > 50 * size)
            assert (frontier.value[row][far] > 0).all()
            assert (frontier.value[row] * meetings.distance[branch])[far].max(initial=0) < 4 * size.max()
            assert frontier.second_order[row].tolist() == ([4, 0] if branch == 0 else [0, -4])
            seen[branch] += far.sum()
    assert (seen > 100).all()


def wall_points(cone, azimuths):
    """(n, 3): where the light falls on a wall of radius 1."""
    feet = np.stack([np.cos(azimuths), -np.sin(azimuths), np.zeros_like(azimuths)]).T
    meetings = cone.meet(feet, np.broadcast_to([0.0, 0.0, 1.0], feet.shape))
    distance = np.where(meetings.flags != 0, meetings.distance, 0).sum(axis=0)
    return feet + distance[:, None] * [0, 0, 1]


def margins(cone, jacobian, *, pixel, azimuth):
    """(k,) value / u(value) for noise of one pixel in zenith and across, and u = 0.001 of baseline and projection."""
    direction = wall_points(cone, np.array([azimuth]))
    direction /= np.linalg.norm(direction)
    zenith = np.arccos(direction[0, 2])
    along = [np.cos(zenith) * np.cos(azimuth), -np.cos(zenith) * np.sin(azimuth), -np.sin(zenith)]
    across = np.sin(zenith) * np.array([-np.sin(azimuth), -np.cos(azimuth), 0])
    by_inputs = np.zeros((5, 2))
    by_inputs[:3] = [[1, 0], *jacobian]
    frontier = cone.frontier(PUPIL, direction)
    turning = frontier.by_direction[:, 0] @ np.column_stack([along, across]) * [pixel, pixel / zenith]
    spread = np.linalg.norm(np.hstack([turning, 1e-3 * frontier.by_parameters[:, 0] @ by_inputs]), axis=1)
    return frontier.value[:, 0] / np.where(spread > 0, spread, 1)


@pytest.mark.skipif(not PUBLISHED.exists(), reason="published_values.json is not beside the checkout")
@pytest.mark.parametrize("off", [60, 30, 15, 8, 4, 2, 1, 0.5, -0.5, -1, -2, -4])
def test_the_margin_falls_towards_the_tangent_azimuth_as_published(off):
    """Equation book 5.5; its margins divide by a drawn standard deviation: 200000 draws know it to 0.2 %."""
    cone = Cone.for_ring(0.5, 1.0, 1.0)
    aim, half_angle, jacobian = ring_angles(0.5, 1.0, 1.0)
    pixel = 2 * (aim + half_angle) / 1024
    touching, _, _ = margins(cone, jacobian, pixel=pixel, azimuth=TANGENT + np.radians(off))
    published = json.loads(PUBLISHED.read_text(encoding="utf-8"))["monte_carlo_cone_D0.5_L1"][f"mc_{off}"]["margin"]
    assert touching == pytest.approx(published, rel=0.01)


def test_the_ring_point_at_the_tangent_azimuth_is_where_the_first_frontier_is_0():
    cone = Cone.for_ring(0.5, 1.0, 1.0)
    azimuths = TANGENT + np.linspace(-0.3, 0.3, 601)
    points = wall_points(cone, azimuths)
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    value = cone.frontier(PUPIL, directions).value[0]
    assert azimuths[value.argmin()] == pytest.approx(TANGENT)
    assert abs(value.min()) < 1e-12
    flags = cone.meet(PUPIL, directions[[0, 299, 301, 600]]).flags
    assert (flags[:, 1:3] & MeetingFlag.GRAZING).all()
    assert not (flags[:, [0, 3]] & MeetingFlag.GRAZING).any()


def test_a_coaxial_cone_never_folds_and_its_near_meeting_recedes_along_the_light():
    cone = Cone(0.0, 0.0, np.radians(40), offset=0.2)
    zenith = np.radians([39.9, 39.0, 30.0, 10.0])
    directions = np.stack([np.sin(zenith), 0 * zenith, np.cos(zenith)]).T
    frontier, meetings = cone.frontier(PUPIL, directions), cone.meet(PUPIL, directions)
    np.testing.assert_allclose(frontier.value[0], (np.sin(np.radians(40)) * np.sin(zenith)) ** 2, rtol=1e-12)
    assert (np.diff(frontier.value[2]) > 0).all()
    assert (np.diff(meetings.distance[0]) < 0).all()
    assert (meetings.flags[1] == MeetingFlag.NONE).all()


def test_the_margin_has_no_jump_where_a_root_changes_its_stable_form():
    """A wall that grows under a fixed clock: every frontier, and the slope of its logarithm, changes smoothly."""
    cone = Cone.for_ring(0.5, 2.0, 1.0)
    radius = np.linspace(0.8, 1.6, 801)
    for azimuth in np.radians([-40.0, -30.0, -20.0, 60.0]):
        feet = radius[:, None] * [np.cos(azimuth), -np.sin(azimuth), 0.0]
        depth = cone.meet(feet, np.broadcast_to([0.0, 0.0, 1.0], feet.shape))
        points = feet + np.where(depth.flags != 0, depth.distance, 0).sum(axis=0)[:, None] * [0, 0, 1]
        directions = points / np.linalg.norm(points, axis=1, keepdims=True)
        value = cone.frontier(PUPIL, directions).value
        for row in value:
            assert np.abs(np.diff(np.log(np.abs(row)))).max() < 0.1

"""Cone meetings against chapter 3 of Swanbom 2007, corrected; and its printed forms fail as the equation book says."""

import closed_forms as book
import numpy as np
import pytest

from calibore.lasers import Cone, MeetingFlag, ring_angles

PUPIL = np.zeros(3)
RIGS = np.random.default_rng(20070501).uniform([0.1, 0.3], [0.9, 4], (40, 2))
AWAY = 1e-2  # discriminant and denominator at least this large: nearer, the closed forms lose digits
ROUNDING = 1e-11  # 1e-16 over the square of AWAY, with room


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def random_rays(rng, n=400):
    return rng.uniform(0.03, 1.45, n), rng.uniform(-np.pi, np.pi, n)


def rig(d, length):
    aim, half_angle, _ = ring_angles(d, length, 1.0)
    return Cone.for_ring(d, length, 1.0), {"alpha": aim, "psi": half_angle}


def wall_rays(cone, azimuths):
    """(n, 3) directions from the pupil to where the light falls on the wall of radius 1."""
    feet = np.stack([np.cos(azimuths), -np.sin(azimuths), 0 * azimuths], axis=-1)
    meetings = cone.meet(feet, np.broadcast_to([0.0, 0.0, 1.0], feet.shape))
    points = feet + np.where(meetings.flags != 0, meetings.distance, 0).sum(axis=0)[:, None] * [0, 0, 1]
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def zenith_of(directions):
    return np.arccos(directions[:, 2])


def test_both_meetings_are_the_two_roots_of_the_closed_form(rng):
    compared = np.zeros(2, dtype=int)
    for d, length in RIGS:
        cone, angles = rig(d, length)
        theta, phi = random_rays(rng)
        below = book.denominator(theta, phi, **angles)
        kept = (book.radicand(theta, phi, **angles) > AWAY) & (np.abs(below) > AWAY)
        theta, phi = theta[kept], phi[kept]
        meetings = cone.meet(PUPIL, book.ray(theta, phi))
        for row, sign in ((0, -1), (1, 1)):
            seen = (meetings.flags[row] != 0) & (meetings.flags[row] & MeetingFlag.BEHIND == 0)
            radius = book.cone_radius(theta[seen], phi[seen], d, sign=sign, **angles)
            np.testing.assert_allclose((meetings.distance[row] * np.sin(theta))[seen], radius, rtol=ROUNDING)
            compared[row] += seen.sum()
    assert (compared > 1000).all()


def test_the_sign_of_the_denominator_and_of_b_tells_how_many_meetings_are_seen(rng):
    for d, length in RIGS:
        cone, angles = rig(d, length)
        theta, phi = random_rays(rng)
        meetings = cone.meet(PUPIL, book.ray(theta, phi))
        found = ((meetings.flags != 0) & (meetings.flags & MeetingFlag.BEHIND == 0)).sum(axis=0)
        below, b = book.denominator(theta, phi, **angles), book.b_star(theta, phi, **angles)
        expected = np.where(below > 0, 1, np.where(b < 0, 2, 0)) * (book.radicand(theta, phi, **angles) >= 0)
        assert np.array_equal(found, expected)


def test_the_first_frontier_is_the_corrected_discriminant(rng):
    for d, length in RIGS:
        cone, angles = rig(d, length)
        theta, phi = random_rays(rng)
        value = cone.frontier(PUPIL, book.ray(theta, phi)).value[0]
        np.testing.assert_allclose(value, book.radicand(theta, phi, **angles), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("under_root", "printed"),
    [
        (book.radicand_as_printed, [-0.004, 0.060, -0.989, -0.674]),
        (book.radicand, [0.200, 0.255, -0.562, -0.333]),
    ],
)
def test_as_printed_the_closed_form_does_not_find_the_wall(under_root, printed):
    """Equation book 1.2: D = 0.5, L = 1, wall at radius 1, azimuths 90, 45, -45, -90 deg."""
    cone, angles = rig(0.5, 1.0)
    phi = np.radians([90, 45, -45, -90])
    theta = zenith_of(wall_rays(cone, phi))
    sign = np.where(book.denominator(theta, phi, **angles) < 0, 1, -1)
    literal = book.cone_radius(theta, phi, 0.5, sign=sign, negated=False, under_root=under_root, **angles)
    np.testing.assert_allclose(literal, printed, rtol=0, atol=0.0005)  # half a unit of the last digit
    np.testing.assert_allclose(book.cone_radius(theta, phi, 0.5, sign=sign, **angles), 1, rtol=1e-12)


def test_the_labels_of_the_two_frontiers_are_swapped(rng):
    for d, length in RIGS:
        cone, angles = rig(d, length)
        phi = np.concatenate([rng.uniform(-1.4, 1.4, 50), np.pi + rng.uniform(-1.4, 1.4, 50)])
        touching = book.zenith_labelled_3_35(phi, **angles)
        np.testing.assert_allclose(touching, book.zenith_of_tangent(phi, **angles), rtol=1e-8)
        assert np.abs(cone.frontier(PUPIL, book.ray(touching, phi)).value[0]).max() < 1e-8
        assert np.abs(book.denominator(touching, phi, **angles)).max() > 1e-3
        parallel = book.zenith_labelled_3_36(phi, **angles)
        frontier = cone.frontier(PUPIL, book.ray(parallel, phi))
        assert np.abs(frontier.value[1:]).min(axis=0).max() < 1e-12  # one of the meetings is at infinity
        assert np.abs(frontier.value[0]).max() > 1e-3


def bisect(function, low, high):
    """Where `function` changes sign."""
    rising = function(high) > 0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if (function(middle) > 0) == rising else (middle, high)
    return (low + high) / 2


@pytest.mark.parametrize(
    ("d", "length", "touching", "parallel"),
    [
        (0.25, 1, -0.23, -7.40),
        (0.50, 1, -1.83, -16.05),
        (0.75, 1, -6.13, -26.48),
        (0.40, 2, -0.37, -11.87),
        (0.50, 2, -0.71, -15.09),
        (0.60, 2, -1.22, -18.45),
    ],
)
def test_the_ring_is_seen_edge_on_and_turns_near_where_the_equation_book_says(d, length, touching, parallel):
    """Equation book, section 3, two decimals of a degree. Between the two azimuths the wall is the NEAR meeting."""
    cone, _ = rig(d, float(length))

    def frontier(degrees):
        return cone.frontier(PUPIL, wall_rays(cone, np.radians([degrees]))).value[:, 0]

    def receding(degrees):
        return frontier(degrees)[1]

    def slope_of_touching(degrees):
        return frontier(degrees + 1e-3)[0] - frontier(degrees - 1e-3)[0]

    edge = bisect(slope_of_touching, -20.0, 20.0)
    assert edge == pytest.approx(touching, abs=0.006)
    assert frontier(edge)[0] == pytest.approx(0, abs=1e-9)
    assert bisect(receding, -60.0, edge) == pytest.approx(parallel, abs=0.006)
    azimuths = np.radians(np.linspace(parallel + 0.1, edge - 2, 20))
    directions = wall_rays(cone, azimuths)
    distance = cone.meet(PUPIL, directions).distance * np.sin(zenith_of(directions))
    np.testing.assert_allclose(distance[0], 1, rtol=1e-9)
    assert (distance[1] > 1.01).all()


def test_discarding_the_nearer_meeting_is_wrong_beside_the_tangent():
    cone, _ = rig(0.5, 1.0)
    directions = wall_rays(cone, np.radians([-10.0]))
    radius = cone.meet(PUPIL, directions).distance[:, 0] * np.sin(zenith_of(directions))
    np.testing.assert_allclose(radius, [1.000, 2.372], atol=0.0005)


def test_the_widest_ray_runs_along_the_invert_light_and_meets_the_crown_light_half_way():
    """Eq. 3-37 (second) and 3-38: smallest radius (1 + D) / 2, at half the projection, as the far meeting."""
    for d, length in RIGS:
        cone, angles = rig(d, length)
        widest = np.arctan((1 + d) / length)
        assert angles["alpha"] + angles["psi"] == pytest.approx(widest, rel=1e-14)
        crown, invert = book.ray(np.full(2, widest), np.array([np.pi / 2, -np.pi / 2]))[:, None]
        x, y, z = cone.meet(PUPIL, crown).distance[1, 0] * crown[0]
        np.testing.assert_allclose([x, -y, z], [0, (1 + d) / 2, length / 2], rtol=1e-12, atol=1e-12)
        value = cone.frontier(PUPIL, invert).value[1:, 0]
        assert np.abs(value).min() < 1e-14

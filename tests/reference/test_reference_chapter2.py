"""Meetings with the cones of the literature review, chapter 2 of Swanbom 2007: coaxial, beside the lens, reversed."""

import closed_forms as book
import numpy as np
import pytest

from calibore.lasers import Cone, MeetingFlag

PUPIL = np.zeros(3)
CASES = 200


@pytest.fixture
def rng():
    return np.random.default_rng(2)


def unit(*components):
    vectors = np.stack(np.broadcast_arrays(*components), axis=-1)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def lit(meetings):
    return (meetings.flags != 0) & (meetings.flags & MeetingFlag.BEHIND == 0)


def test_a_coaxial_cone_ahead_of_the_lens_is_met_where_2_1_and_2_2_say_from_the_image_plane(rng):
    for _ in range(CASES):
        f, a, w = rng.uniform(0.5, 1.5), rng.uniform(0.2, 2), rng.uniform(0.2, 0.9)
        r = f * np.tan(w) * rng.uniform(0.02, 0.98, 20)
        directions = unit(r, 0, f)
        meetings = Cone(0.0, 0.0, w, offset=a).meet(PUPIL, directions)
        radius, _, z = (meetings.distance[0][:, None] * directions).T
        assert lit(meetings)[0].all()
        assert not lit(meetings)[1].any()
        np.testing.assert_allclose([radius, z + f], book.coaxial_point(r, f, a=a + f, w=w), rtol=1e-12)
        literal = book.coaxial_point(r, f, a=a, w=w)  # the apex measured from the lens, as the text says
        assert (np.abs(literal[0] / radius - 1) > 1e-3).all()


def test_a_reversed_cone_is_imaged_where_2_8_says(rng):
    for _ in range(CASES):
        f, m, alpha = rng.uniform(0.5, 1.5), rng.uniform(1, 6), rng.uniform(0.3, 1.3)
        radius = rng.uniform(0.1, 0.95) * m * np.tan(alpha)
        r = book.reversed_image_radius(radius, f, m=m, alpha=alpha)
        direction = unit(r, 0, f)[None]
        meetings = Cone(0.0, 0.0, np.pi - alpha, offset=m).meet(PUPIL, direction)
        assert lit(meetings)[:, 0].tolist() == [False, True]  # the pupil stands in the light: the ray leaves it
        x, _, z = meetings.distance[1, 0] * direction[0]
        np.testing.assert_allclose([x, z], [radius, m - radius / np.tan(alpha)], rtol=1e-11)


def beside(f, b, w):
    """Apex in the image plane, f behind the lens and b to its right."""
    return Cone(b, 0.0, w, np.pi / 2, -f)


def test_a_cone_beside_the_lens_is_met_where_2_3_to_2_5_say_with_f_squared(rng):
    compared = np.zeros(2, dtype=int)
    for _ in range(CASES):
        f, b, w = rng.choice([0.6, 1.4]) * rng.uniform(0.9, 1.1), rng.uniform(0.2, 2), rng.uniform(0.2, 0.6)
        x, y = rng.uniform(-2, 2, 50), rng.uniform(-0.5, 0.5, 50)
        square = (np.tan(w) * f) ** 2
        kept = square * (y**2 + (x + b) ** 2) - y**2 * b**2 > 1e-2
        kept &= np.abs(x**2 + y**2 - square) > 1e-2
        x, y = x[kept], y[kept]
        directions = unit(x, y, f)
        meetings = beside(f, b, w).meet(PUPIL, directions)
        expected = book.beside_points(x, y, f, b=b, w=w, square=f**2) + np.array([[b / 2], [0], [-f]])
        seen = (expected[:, 2] > -f) & (expected[:, 2] > 0)  # on the lit nappe, ahead of the lens
        assert np.array_equal(seen.sum(axis=0), lit(meetings).sum(axis=0))
        reach = np.sort(np.where(seen, np.linalg.norm(expected, axis=1), np.inf), axis=0)
        found = np.sort(np.where(lit(meetings), meetings.distance, np.inf), axis=0)
        np.testing.assert_allclose(found, reach, rtol=1e-10)
        literal = book.beside_points(x, y, f, b=b, w=w, square=1.0) + np.array([[b / 2], [0], [-f]])
        assert (np.abs(literal - expected).max(axis=(0, 1)) > 1e-4).all()
        compared += np.bincount(seen.sum(axis=0), minlength=3)[1:]
    assert (compared > 100).all()


def test_on_the_row_through_the_lens_the_light_lies_where_2_6_and_2_7_say_with_the_plus(rng):
    for _ in range(CASES):
        f, b, w = rng.uniform(0.5, 1.5), rng.uniform(0.2, 2), rng.uniform(0.2, 0.6)
        x = f * np.tan(w) * rng.uniform(1.1, 5, 20)
        directions = unit(x, 0, f)
        meetings = beside(f, b, w).meet(PUPIL, directions)
        right, _, z = (meetings.distance[1][:, None] * directions).T  # where the ray leaves the light, on the far side
        np.testing.assert_allclose([right - b / 2, z + f], book.beside_line(x, f, b=b, w=w, arm=x + b), rtol=1e-11)
        literal, _ = book.beside_line(x, f, b=b, w=w, arm=x - b)
        assert (np.abs(right - b / 2 - literal) > 1e-3).all()

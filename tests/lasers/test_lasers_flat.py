"""Sheets and beams: one meeting per ray, on the surface, ahead and lit."""

import numpy as np
import pytest
from rays_everywhere import rays, surfaces

from calibore.errors import InputError
from calibore.lasers import GRAZING_SINE, Beam, MeetingFlag, Sheet


@pytest.mark.parametrize("kind", ["plane", "sheet", "beam"])
def test_every_admissible_meeting_lies_on_the_surface_ahead_of_the_ray(kind):
    for surface in surfaces(kind):
        origins, directions = rays(np.random.default_rng(2))
        meetings = surface.meet(origins, directions)
        good = meetings.admissible[0]
        points = origins[good] + meetings.distance[0][good, None] * directions[good]
        assert 0.02 < good.mean() < 0.9
        assert np.abs(surface.value(points)).max() < 1e-12 * np.abs(points).max()
        assert (meetings.distance[0][good] > 0).all()
        sine = directions @ surface.normal / np.linalg.norm(surface.normal)
        assert np.abs(sine[good]).min() >= GRAZING_SINE


@pytest.mark.parametrize("kind", ["plane", "sheet", "beam"])
def test_the_frontier_is_positive_where_and_only_where_the_surface_is_ahead(kind):
    for surface in surfaces(kind):
        origins, directions = rays(np.random.default_rng(3))
        meetings = surface.meet(origins, directions)
        lit = meetings.flags[0] != MeetingFlag.NONE
        ahead = (meetings.flags[0] & MeetingFlag.BEHIND) == 0
        assert np.array_equal(surface.frontier(origins, directions).value[0][lit] > 0, ahead[lit])


def test_a_flat_meeting_recedes_as_the_reciprocal_of_its_frontier():
    """So that the relative second-order term of the distance, (u(value) / value), is 1 / (4 margin)."""
    for surface in surfaces("sheet") + surfaces("plane"):
        origins, directions = rays(np.random.default_rng(4))
        meetings, frontier = surface.meet(origins, directions), surface.frontier(origins, directions)
        good = meetings.admissible[0]
        reach = np.abs(surface.value(origins))
        np.testing.assert_allclose((meetings.distance * frontier.value)[0][good], reach[good], rtol=1e-12)
        assert frontier.second_order.tolist() == [[4]]


def test_a_sheet_holds_the_points_of_its_equation():
    rng = np.random.default_rng(5)
    for sheet in surfaces("sheet"):
        y, z = rng.normal(size=(2, 100))
        points = np.stack([sheet.offset + sheet.skew * y + sheet.lean * z, y, z]).T
        assert np.abs(sheet.value(points)).max() < 1e-14 * np.abs(points).max() * 10


def test_the_plane_of_a_beam_holds_the_beam_and_faces_the_pupil():
    for beam in surfaces("beam", 100):
        along = np.linspace(-5, 5, 11)[:, None] * beam.direction
        assert np.abs(beam.value(beam.source + along)).max() < 1e-14 * 10
        across = np.cross(beam.direction, beam.source)
        assert abs(beam.normal @ across) < 1e-15 * 10  # at right angles to the plane of beam and pupil
        assert beam.normal @ beam.normal == pytest.approx(1)
        assert beam.value(np.zeros((1, 3)))[0] == pytest.approx(-np.linalg.norm(across))


def test_a_ray_aimed_at_a_spot_on_the_beam_finds_it():
    rng = np.random.default_rng(6)
    for beam in surfaces("beam", 100):
        spots = beam.source + rng.uniform(0.01, 3, 50)[:, None] * beam.direction
        reach = np.linalg.norm(spots, axis=1)
        meetings = beam.meet(np.zeros(3), spots / reach[:, None])
        assert ((meetings.flags[0] & MeetingFlag.BEHIND) == 0).all()
        sine = spots @ beam.normal / reach  # where the ray runs along the beam, the spot's distance is worth less
        assert (np.abs(meetings.distance[0] - reach) < 1e-14 * 10 * reach / sine).all()


def test_a_ray_that_passes_a_beam_meets_its_plane_next_to_the_nearest_point():
    rng, size = np.random.default_rng(7), 1e-4
    for beam in surfaces("beam", 100):
        spots = beam.source + rng.uniform(0.5, 1, 50)[:, None] * beam.direction
        side = np.cross(beam.direction, beam.source)
        aimed = spots + size * side / np.linalg.norm(side)
        meetings = beam.meet(np.zeros(3), aimed / np.linalg.norm(aimed, axis=1, keepdims=True))
        points = meetings.distance[0][:, None] * aimed / np.linalg.norm(aimed, axis=1, keepdims=True)
        np.testing.assert_allclose(beam.beam_distance(points), size, rtol=1e-6)


def test_there_is_no_light_behind_the_laser():
    rng = np.random.default_rng(8)
    for beam in surfaces("beam", 20):
        back = beam.source - rng.uniform(0.01, 3, 50)[:, None] * beam.direction
        meetings = beam.meet(np.zeros(3), back / np.linalg.norm(back, axis=1, keepdims=True))
        assert (meetings.flags == MeetingFlag.NONE).all()


def test_the_distance_to_a_beam_is_the_least_distance_to_its_points():
    along = np.linspace(0, 6, 60001)[:, None]
    for beam in surfaces("beam", 5):
        points = np.random.default_rng(9).uniform(-1, 1, (20, 3))
        lit = beam.source + along * beam.direction
        least = [np.linalg.norm(lit - point, axis=1).min() for point in points]
        np.testing.assert_allclose(beam.beam_distance(points), least, atol=1e-4)
    assert beam.beam_distance(beam.source[None] - 2 * beam.direction)[0] == pytest.approx(2)


@pytest.mark.parametrize("point", [(0, 0, 0), (0.2, 0.3, 0.4), (-0.2, -0.3, -0.4)])
def test_a_beam_through_the_pupil_is_refused(point):
    zenith, clock = np.arctan2(np.hypot(0.2, 0.3), 0.4), np.arctan2(0.2, -0.3)
    with pytest.raises(InputError, match="A beam must pass the pupil at"):
        Beam(*point, zenith, clock)


def test_numbers_of_sheet_and_beam_must_be_finite():
    with pytest.raises(InputError, match="offset, skew and lean are finite"):
        Sheet(np.nan)
    with pytest.raises(InputError, match=r"point .m. and angles .rad. are finite"):
        Beam(0.1, 0, 0, np.inf, 0)

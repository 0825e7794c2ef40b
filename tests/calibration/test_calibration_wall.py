"""What a covariance means in metres on the wall, and what becomes of it when correlations are ignored."""

from dataclasses import replace

import numpy as np
import pytest
from made_calibrations import INCH, RADIUS, cone_rig, known, plane_rig, published_head

from calibore.calibration import wall_uncertainty
from calibore.calibration._on_the_wall import wall_map, wall_pixels
from calibore.errors import InputError
from calibore.lasers import Beam
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, monte_carlo, triangulate
from calibore.uncertainty import Covariance

DRAWS = 5000
MONTE_CARLO = 0.03
"""Three standard deviations of an sd from 5000 draws."""


def test_ignoring_correlations_makes_the_published_head_sixty_times_worse():
    """The source's own fit: u(6 in) = 0.0016 in; without correlations 0.100 in (equations.md, 5.1)."""
    found = wall_uncertainty(published_head(), radii=[6 * INCH])
    assert found.mean[0] / INCH == pytest.approx(0.0016, abs=0.00005)
    assert found.mean_uncorrelated[0] / INCH == pytest.approx(0.100, rel=0.05)
    assert 55 < found.mean_uncorrelated[0] / found.mean[0] < 70


@pytest.mark.parametrize("rig", [known(plane_rig(), size=0.3), known(cone_rig(), size=0.3), published_head()])
def test_the_uncertainty_is_the_scatter_of_rigs_drawn_from_the_covariance(rig):
    clock = np.radians([110.0, 180.0, 250.0])
    found = wall_uncertainty(rig, radii=[RADIUS], clock=clock)
    u, v = wall_pixels(rig, clock, np.full(3, RADIUS))
    rng = np.random.default_rng(8)
    scatter = monte_carlo(rig, u, v, u_pixel=0.0, draws=DRAWS, rng=rng, prior_radius=RADIUS)
    np.testing.assert_allclose(scatter.radius.u, found.u[0], rtol=MONTE_CARLO)


def test_correlations_do_not_matter_where_there_are_none():
    rig = plane_rig().knowing(Covariance.independent({"camera.k": 1.0, "laser.baseline": 1e-4}))
    found = wall_uncertainty(rig, radii=np.linspace(0.7, 1.1, 5) * RADIUS)
    np.testing.assert_allclose(found.u, found.u_uncorrelated, rtol=1e-12)
    np.testing.assert_allclose(found.mean, np.sqrt((found.u**2).mean(axis=1)), rtol=1e-12)


def test_of_two_lasers_the_better_known_counts():
    rig = known(cone_rig(lasers=2))
    found = wall_uncertainty(rig, radii=[RADIUS])
    for laser in rig.lasers:
        alone = Rig("single-cone", rig.camera, (laser,))
        table = rig.laser_table(rig.lasers.index(laser))
        mine = {name: name.replace(table, "laser") for name in rig.covariance.names if name.startswith(table)}
        names = [*mine, *(name for name in rig.covariance.names if name.startswith("camera"))]
        matrix = rig.covariance.restricted(names).matrix
        alone = alone.knowing(Covariance([mine.get(name, name) for name in names], matrix))
        single = wall_uncertainty(alone, radii=[RADIUS])
        seen = np.isfinite(single.u)
        assert (found.u[seen] <= single.u[seen] * (1 + 1e-9)).all()
    assert np.isfinite(found.u).sum() >= seen.sum()


def test_a_wall_outside_the_picture_is_not_measured():
    camera = Camera(1024, 768, Lens("equidistant", 900.0, 384.0), (512.0, 384.0))
    found = wall_uncertainty(known(plane_rig(camera)), radii=[0.3 * RADIUS, RADIUS])
    assert np.isfinite(found.u[0]).all()
    assert np.isnan(found.u[1]).all()
    assert np.isnan(found.mean[1])


def test_on_the_axis_there_is_no_wall():
    for rig in (known(plane_rig()), known(cone_rig())):
        assert np.isnan(wall_uncertainty(rig, radii=[0.0]).mean).all()


def test_a_spot_array_is_judged_at_its_beams():
    beams = [Beam(0.02, 0.0, 0.0, 1.1, clock) for clock in (1.0, 2.5, 4.0)]
    rig = Rig("spot-array", plane_rig().camera, tuple(Laser(beam) for beam in beams))
    rig = rig.knowing(Covariance.independent({"camera.k": 1.0}))
    found = wall_uncertainty(rig, radii=[RADIUS])
    np.testing.assert_allclose(found.clock, [1.0, 2.5, 4.0])
    assert found.u.shape == (1, 3)


def test_the_map_agrees_with_the_ring_where_it_crosses_the_wall():
    rig = known(plane_rig())
    found = wall_map(rig, nominal_radius=RADIUS)
    row, column = np.unravel_index(np.nanargmin(np.abs(found.radius - RADIUS)), found.radius.shape)
    at = triangulate(rig, found.u[[column]], found.v[[row]])
    ring = wall_uncertainty(rig, radii=at.radius, clock=at.clock)
    assert found.uncertainty[row, column] == pytest.approx(ring.u[0, 0], rel=1e-6)
    assert np.isfinite(found.line).any()


def test_a_rig_that_states_nothing_is_refused():
    with pytest.raises(InputError, match="states no uncertainty"):
        wall_uncertainty(replace(plane_rig(), covariance=None), radii=[RADIUS])

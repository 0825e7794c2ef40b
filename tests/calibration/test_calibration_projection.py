"""How uncertain the direction behind a pixel is: exact, without what a turn of the whole camera could have done."""

import numpy as np
import pytest
from made_calibrations import fisheye, known, plane_rig

from calibore.calibration import projection_uncertainty
from calibore.calibration._projection import image_grid, implied_turns, projection_modes, turns_against
from calibore.errors import InputError
from calibore.optics import Camera, Lens
from calibore.rigs import ValidRegion
from calibore.uncertainty import Covariance

DRAWS = 5000
MONTE_CARLO = 0.03
"""Three standard deviations of an sd from 5000 draws: 3 / sqrt(10000)."""


@pytest.fixture(scope="module")
def scatter():
    """Mean square motions (n, 2, 2) [px^2] of directions in cameras drawn from a covariance: kept, and less a turn."""
    rig, rng = known(plane_rig(), size=0.5), np.random.default_rng(3)
    grid = image_grid(rig.camera, rows=10)
    directions, here = rig.camera.unproject(*grid).direction, np.stack(grid, axis=1)
    modes, turns = projection_modes(rig.camera, rig.covariance, *grid)
    weights = implied_turns(modes, turns).weights
    cameras = _drawn_cameras(rig, rng)
    draws = np.array([np.stack(camera.project(directions), axis=1) for camera in cameras]) - here
    left = draws + np.einsum("nki,id->dnk", turns, turns_against(draws.transpose(1, 2, 0), turns, weights))
    return rig, grid, [np.einsum("dni,dnj->nij", one, one) / DRAWS for one in (draws, left)]


def _drawn_cameras(rig, rng):
    camera, lens = rig.camera, rig.camera.lens
    known = rig.covariance.restricted(camera.parameter_names)
    for k, c1, c2, aspect, u, v in known.draw(rng, DRAWS).tolist():
        moved = Lens(lens.law, lens.k + k, lens.half_height, lens.c1 + c1, lens.c2 + c2)
        point = camera.principal_point[0] + u, camera.principal_point[1] + v
        yield Camera(camera.width, camera.height, moved, point, camera.aspect + aspect)


@pytest.mark.parametrize("keep_rotation", [True, False])
def test_the_uncertainty_is_the_scatter_of_cameras_drawn_from_the_covariance(scatter, keep_rotation):
    rig, grid, (kept, left) = scatter
    found = projection_uncertainty(rig.camera, rig.covariance, *grid, keep_rotation=keep_rotation)
    drawn_sd = np.sqrt(np.linalg.eigvalsh(kept if keep_rotation else left)[:, 1])
    assert np.sqrt((drawn_sd**2).mean() / (found.sd**2).mean()) == pytest.approx(1, abs=MONTE_CARLO)
    assert np.quantile(np.abs(drawn_sd / found.sd - 1), 0.9) < MONTE_CARLO


def test_a_turn_of_the_camera_is_no_uncertainty_of_it():
    """A tele lens cannot tell a shifted principal point from a turn: nearly nothing is left of 1 px."""
    camera = Camera(1024, 768, Lens("perspective", 9000.0, 384.0), (512.0, 384.0))
    covariance = Covariance.independent({"camera.principal_point_u": 1.0, "camera.principal_point_v": 1.0})
    grid = image_grid(camera)
    assert projection_uncertainty(camera, covariance, *grid).sd.max() < 0.01
    assert projection_uncertainty(camera, covariance, *grid, keep_rotation=True).sd == pytest.approx(1, abs=0.01)


def test_turns_themselves_are_taken_out_to_rounding():
    camera = fisheye()
    _, turns = projection_modes(camera, Covariance.independent({"camera.k": 1.0}), *image_grid(camera))
    left = turns + turns @ implied_turns(turns, turns).turns
    assert np.abs(left).max() < 1e-9 * np.abs(turns).max()


def test_the_stated_sd_is_that_of_the_worst_direction():
    rig = known(plane_rig())
    found = projection_uncertainty(rig.camera, rig.covariance, *image_grid(rig.camera))
    np.testing.assert_allclose(found.sd**2, np.linalg.eigvalsh(found.covariance)[:, 1], rtol=1e-9)


def test_parameters_of_lasers_move_no_direction():
    rig = known(plane_rig())
    camera_only = rig.covariance.restricted([name for name in rig.covariance.names if name.startswith("camera.")])
    grid = image_grid(rig.camera)
    both = [projection_uncertainty(rig.camera, one, *grid).sd for one in (rig.covariance, camera_only)]
    np.testing.assert_allclose(*both, rtol=1e-9)


def test_where_the_lens_sees_nothing_there_is_no_uncertainty_to_state():
    camera = Camera(1024, 768, Lens("sine-law", 400.0, 384.0), (512.0, 384.0))
    found = projection_uncertainty(camera, Covariance.independent({"camera.k": 1.0}), [512.0, 1000.0], [300.0, 700.0])
    assert np.isfinite(found.sd[0])
    assert np.isnan(found.sd[1])


def test_a_turn_is_judged_where_the_calibration_had_points():
    rig = known(plane_rig())
    narrow = ValidRegion(zenith=(0.0, 0.4))
    inside = image_grid(rig.camera, valid=narrow)
    zenith = np.arccos(rig.camera.unproject(*inside).direction[:, 2])
    assert zenith.max() <= 0.4
    own = projection_uncertainty(rig.camera, rig.covariance, *inside, valid=narrow).sd
    whole = projection_uncertainty(rig.camera, rig.covariance, *inside).sd
    assert (own**2).mean() < (whole**2).mean()


def test_a_region_that_the_image_does_not_show_is_refused():
    with pytest.raises(InputError, match="valid region"):
        image_grid(fisheye(), valid=ValidRegion(zenith=(3.0, 3.1)))

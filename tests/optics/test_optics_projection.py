"""Derivatives of the projection, for every lens law, with residual, walking pupil and port."""

import numpy as np
import pytest

from calibore.lasers import Plane
from calibore.optics import LENS_NAMES, Camera, FlatPort, Lens
from calibore.rigs import Laser, Rig, moved

STEP = 1e-6  # relative; central differences of it are right to about 1e-9 of the value


def _camera(law, rng, *, walk=False, port=False):
    polynomial = (0.03, -0.01) if law == "polynomial" else ()
    lens = Lens(law, 400.0, 384.0, c1=0.02, c2=-0.004, polynomial=polynomial)
    return Camera(
        1024,
        768,
        lens,
        (510.0 + rng.normal(), 385.0 + rng.normal()),
        1.01,
        pupil_walk=(0.002, -0.001) if walk else (),
        port=FlatPort(0.008, 1.5, 0.02) if port else None,
    )


def _points(rng, n=60):
    zenith, azimuth, distance = rng.uniform(0.05, 0.9, n), rng.uniform(0, 2 * np.pi, n), rng.uniform(0.3, 1.5, n)
    ray = np.stack([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)], 1)
    return ray * distance[:, None]


@pytest.mark.parametrize("law", LENS_NAMES)
@pytest.mark.parametrize(("walk", "port"), [(False, False), (True, False), (True, True)])
def test_projection_moves_with_point_and_parameters_as_it_says(law, walk, port):
    rng = np.random.default_rng(3)
    camera, points = _camera(law, rng, walk=walk, port=port), _points(rng)
    found = camera.project_with_sensitivities(points)
    pixels = np.stack(camera.project(points), 1)
    assert np.array_equal(np.stack([found.u, found.v], 1), pixels)
    for axis in range(3):
        step = np.eye(3)[axis] * STEP
        slope = (np.stack(camera.project(points + step), 1) - np.stack(camera.project(points - step), 1)) / (2 * STEP)
        np.testing.assert_allclose(found.by_point[:, :, axis], slope, atol=1e-6 * np.abs(slope).max())
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(0.3)),))
    for number, name in enumerate(camera.parameter_names):
        high, low = (np.stack(moved(rig, {name: sign * STEP}).camera.project(points), 1) for sign in (1, -1))
        slope = (high - low) / (2 * STEP)
        np.testing.assert_allclose(
            found.by_parameters[:, :, number], slope, atol=2e-6 * max(np.abs(slope).max(), 1.0), err_msg=name
        )


def test_points_behind_the_lens_have_no_place_and_no_slope():
    camera = _camera("perspective", np.random.default_rng(1))
    found = camera.project_with_sensitivities([[0.1, 0.0, -1.0], [0.1, 0.0, 1.0]])
    assert np.isnan(found.u[0])
    assert np.isnan(found.by_point[0]).all()
    assert np.isfinite(found.by_parameters[1]).all()

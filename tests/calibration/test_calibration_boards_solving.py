"""Camera and poses from marks of boards: derivatives, starting values, the minimum, its covariance."""

from dataclasses import replace

import numpy as np
import pytest
from calibration_coverage import outcome
from scipy.stats import chi2
from simulated_boards import CORNERS, SIZE, SQUARE, data_of, held_boards, law_camera, marks_of, places, truth_of

from calibore.calibration._boards._bundle import Estimate, bundle, shared_covariance
from calibore.calibration._boards._data import rotation_vectors, rotations
from calibore.calibration._boards._dot_shift import dot_shift
from calibore.calibration._boards._fit import fit_boards
from calibore.calibration._boards._models import HIGHEST
from calibore.calibration._boards._start import first_estimates, poses_from_rays
from calibore.calibration._lens_models import LensModel
from calibore.errors import InputError
from calibore.optics import LENS_LAWS
from calibore.simulation import unknown_fisheye

NOISE = 0.05
COVERED = 40


def test_derivatives_by_camera_poses_and_bends_are_those_of_the_projection():
    rng = np.random.default_rng(1)
    camera = unknown_fisheye(*SIZE, rng=rng)
    data = data_of(marks_of(camera, held_boards(camera, rng, 3), rng, noise=1e-6))
    poses = poses_from_rays(data, camera)
    poses[0, :3] *= 1e-5  # a board that is hardly turned: where the series of the rotation counts
    poses[0, 3:] = 0.01, 0.02, 0.4
    bends = np.array([2e-4, -1e-4, 3e-4])
    found = data.predicted(camera, poses, bends)
    for column in range(6):
        step = np.zeros(6)
        step[column] = 1e-6
        ahead, behind = (data.predicted(camera, poses + sign * step, bends).pixel for sign in (1, -1))
        np.testing.assert_allclose(found.by_pose[:, :, column], (ahead - behind) / 2e-6, rtol=1e-6, atol=1e-4)
    for column in range(3):
        step = np.zeros(3)
        step[column] = 1e-6
        ahead, behind = (data.predicted(camera, poses, bends + sign * step).pixel for sign in (1, -1))
        np.testing.assert_allclose(found.by_bend[:, :, column], (ahead - behind) / 2e-6, rtol=1e-6, atol=1e-4)


def test_poses_follow_from_rays_of_any_zenith():
    rng = np.random.default_rng(2)
    camera = law_camera(rng, "equidistant", widest=150.0)
    poses = held_boards(camera, rng, 12)
    data = data_of(marks_of(camera, poses, rng, noise=1e-9))
    found = poses_from_rays(data, camera)
    middle = (places().max(axis=0) + places().min(axis=0)) / 2
    true = np.column_stack(
        [rotation_vectors(np.array([pose.rotation for pose in poses])), [pose.apply(middle) for pose in poses]]
    )
    np.testing.assert_allclose(found, true, atol=1e-6)  # noise of 1e-9 px and rounding
    points, _ = data.points(found)
    assert (points[:, 2] < 0).any(), "no mark lies beyond 90 deg, so the test says nothing of it"


@pytest.mark.parametrize("law", LENS_LAWS)
def test_an_unknown_lens_is_found_from_nothing(law):
    rng = np.random.default_rng(3)
    camera = law_camera(rng, law)
    data = data_of(marks_of(camera, held_boards(camera, rng, 8), rng, noise=NOISE))
    estimates = {start.model.law: start for start in first_estimates(data, (LensModel(law),))}
    found = bundle(data, estimates[law])
    u = np.sqrt(np.diag(shared_covariance(data, found)))
    assert found.converged
    assert abs(found.values[0] - camera.lens.k) < 4 * u[0]  # one in 16 000 by chance
    assert u[0] < 0.01 * camera.lens.k


def test_a_law_that_cannot_see_the_marks_is_left_out():
    rng = np.random.default_rng(4)
    camera = law_camera(rng, "equidistant", widest=150.0)
    data = data_of(marks_of(camera, held_boards(camera, rng, 10), rng))
    with pytest.raises(InputError, match="does not image all marks"):
        bundle(data, replace(truth_of(camera, data), model=LensModel("perspective")))


def test_the_search_ends_where_opencv_ends():
    cv2 = pytest.importorskip("cv2")
    rng = np.random.default_rng(5)
    camera = law_camera(rng, "perspective", widest=35.0)
    marks = marks_of(camera, held_boards(camera, rng, 10), rng)
    data = data_of([replace(one, sigmas=None) for one in marks])
    ours = bundle(data, truth_of(camera, data), settled=1e-14)
    boards = [places().astype(np.float32)] * len(marks)
    seen = [np.column_stack([one.u, one.v]).astype(np.float32) for one in marks]
    flags = cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST
    rms, matrix, *_ = cv2.calibrateCamera(boards, seen, SIZE, None, None, flags=flags)
    assert rms == pytest.approx(np.sqrt(2) * ours.rms, rel=1e-4)  # single precision of the marks it takes
    theirs = [matrix[0, 0], matrix[1, 1] / matrix[0, 0], matrix[0, 2], matrix[1, 2]]
    u = np.sqrt(np.diag(shared_covariance(data, ours)))
    assert (np.abs(ours.values - theirs) < 0.01 * u).all()


def test_regions_contain_the_truth_as_often_as_stated_and_u_is_the_scatter():
    """With random laws, scales, poses, numbers of boards and noise; of 300, see `python -m benchmarks calibration`."""
    cases = [outcome("boards", seed) for seed in range(COVERED)]
    assert np.mean([one.held for one in cases]) > 0.84  # of 40, fewer in one of 100
    # six places in the image that are much alike, over four parameters: as good as 2 independent ones per case
    assert np.sqrt(np.mean([one.errors**2 for one in cases])) == pytest.approx(1, abs=0.2)


def test_the_full_fit_states_the_covariance_of_the_search():
    """Poses eliminated, or all parameters in one QR; what neighbours seem to share by chance moves it little."""
    rng = np.random.default_rng(7)
    camera = law_camera(rng, "equisolid-angle")
    data = data_of(marks_of(camera, held_boards(camera, rng, 9), rng), u_bend=2e-4)
    found = bundle(data, truth_of(camera, data))
    fit = fit_boards(data, found, neighbours=False)
    np.testing.assert_allclose(fit.fit.u[:4], np.sqrt(np.diag(shared_covariance(data, found))), rtol=1e-2)
    assert (
        np.abs(fit.fit.values[:4] - found.values) < 0.02 * fit.fit.u[:4]
    ).all()  # each weighs its prior by its own noise
    np.testing.assert_allclose(fit_boards(data, found).fit.u[:4], fit.fit.u[:4], rtol=0.15)


def test_a_bent_board_is_told_and_does_not_bend_the_lens():
    rng = np.random.default_rng(8)
    camera, bends = law_camera(rng, "stereographic", widest=60.0), (6e-4, -3e-4, 2e-4)
    marks = marks_of(camera, held_boards(camera, rng, 14), rng, bends=bends)
    data = data_of(marks, u_bend=5e-4)
    truth = truth_of(camera, data)
    found = fit_boards(data, bundle(data, truth))
    names = found.fit.names
    for name, true in zip(("board.bend_along", "board.bend_down", "board.twist"), bends, strict=True):
        assert abs(found.fit.value(name) - true) < 4 * found.fit.u[names.index(name)] < 2e-4
    error = found.fit.values[:4] - truth.values
    assert error @ np.linalg.solve(found.covariance, error) < chi2.ppf(0.999, 4)
    stiff = bundle(data_of(marks), truth)
    assert stiff.rms > 1.5 * found.estimate.rms


def test_the_image_of_a_dot_is_not_that_of_its_centre():
    """Against the mean over many points of each dot, each weighted by the area it has in the image."""
    rng = np.random.default_rng(9)
    camera = unknown_fisheye(*SIZE, rng=rng)
    data = data_of(marks_of(camera, held_boards(camera, rng, 2), rng, noise=1e-6))
    estimate = Estimate(HIGHEST, np.zeros(8), poses_from_rays(data, camera), 0 * data.pixel, SIZE)
    estimate.__dict__["camera"] = camera
    diameter = 0.6 * SQUARE
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 61)] * 2), axis=-1).reshape(-1, 2) * diameter
    disc = grid[np.hypot(*grid.T) < diameter / 2]
    shift = dot_shift(data, estimate, diameter)
    rotation = rotations(estimate.poses[:, :3])
    for mark in range(0, data.owner.size, 9):
        turned = rotation[data.owner[mark]]
        centre = turned @ data.place[mark] + estimate.poses[data.owner[mark], 3:]
        points = centre + np.column_stack([disc, 0 * disc[:, 0]]) @ turned.T
        area = np.abs(np.linalg.det(camera.project_with_sensitivities(points).by_point @ turned[:, :2]))
        mean = area @ np.stack(camera.project(points), axis=1) / area.sum()
        np.testing.assert_allclose(shift[mark], mean - np.stack(camera.project(centre[None]), axis=1)[0], atol=2e-3)
    assert np.abs(shift).max() > 0.02  # px; the grid of 61 points across a dot is good for a tenth of that


def test_marks_of_a_short_row_do_not_upset_the_board():
    """Of a ChArUco board some rows may show one corner only."""
    rng = np.random.default_rng(10)
    camera = law_camera(rng, "equidistant")
    data = data_of(marks_of(camera, held_boards(camera, rng, 8), rng))
    kept = rng.random(data.owner.size) < 0.5
    part = data.only(kept)
    found = fit_boards(part, bundle(part, truth_of(camera, part)))
    assert found.fit.noise == pytest.approx(NOISE, rel=0.2)
    assert part.boards == data.boards
    assert CORNERS[0] * CORNERS[1] * 8 == data.owner.size

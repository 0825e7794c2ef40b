"""Which lens model is chosen, what contradicts is left out, and what cannot be answered is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from simulated_boards import SIZE, SQUARE, held_boards, law_camera, marks_of, pictures_of, places

from calibore.calibration._boards._calibrate import calibration_of
from calibore.calibration._boards._pictures import BoardTargetFile
from calibore.calibration._boards._sufficiency import distinct_poses
from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import LENS_LAWS
from calibore.simulation import unknown_fisheye
from calibore.targets import BoardMarks

NOISE = 0.05


@pytest.fixture(scope="module")
def fisheye():
    """A camera that no law fits, its boards, and what is found from them."""
    rng = np.random.default_rng(11)
    camera = unknown_fisheye(*SIZE, rng=rng, widest=1.7)
    marks = marks_of(camera, held_boards(camera, rng, 14), rng, noise=NOISE)
    return camera, marks, calibration_of(pictures_of(marks))


def recommended(calibration):
    return next(row for row in calibration.models if row.remark == "recommended")


def test_a_lens_that_no_law_fits_is_given_a_freer_model(fisheye):
    _, _, calibration = fisheye
    chosen, laws = recommended(calibration), [row for row in calibration.models if row.model in LENS_LAWS]
    assert len(laws) == 5
    assert chosen.model.startswith("polynomial") or "+ c1" in chosen.model
    assert chosen.rmse <= 1.1 * NOISE
    assert all("evidence" in row.remark and row.rmse > 1.2 * chosen.rmse for row in laws)
    assert min(row.bic for row in calibration.models) == 0
    assert calibration.noise == pytest.approx(NOISE, rel=0.1)


def test_its_errors_over_the_picture_are_those_it_states(fisheye):
    camera, _, calibration = fisheye
    zenith = np.linspace(0.05, 1.0, 20) * calibration.valid.zenith[1]
    points = np.column_stack([np.sin(zenith), 0 * zenith, np.cos(zenith)])
    image = calibration.camera.project_with_sensitivities(points)
    index = [calibration.camera.parameter_names.index(name) for name in calibration.values]
    rows = image.by_parameters[:, 0, index]
    u = np.sqrt(np.einsum("ni,ij,nj->n", rows, calibration.covariance.matrix, rows))
    error = image.u - camera.project(points)[0]
    assert (np.abs(error) < 4 * u).all()
    assert u.max() < 0.5


def test_the_first_finding_is_the_recommendation_with_its_reason(fisheye):
    calibration = fisheye[2]
    assert calibration.findings[0].startswith(f"Lens: {recommended(calibration).model}, k = ")
    assert "the best simpler one" in calibration.findings[0]


def test_the_evidence_holds_every_residual_and_pose(fisheye):
    _, marks, calibration = fisheye
    observations = calibration.observations
    assert observations.residual.size == 2 * sum(one.u.size for one in marks)
    assert observations.names[: len(calibration.values)] == tuple(calibration.values)
    assert len(observations.names) == len(calibration.values) + 6 * len(marks)
    assert set(observations.file) == set(range(len(marks)))


def test_a_lens_that_follows_a_law_is_given_its_law_back():
    rng = np.random.default_rng(5)
    camera = law_camera(rng, "sine-law")
    calibration = calibration_of(pictures_of(marks_of(camera, held_boards(camera, rng, 12), rng)))
    assert recommended(calibration).model == "sine-law"
    assert abs(calibration.values["camera.k"] - camera.lens.k) < 4 * calibration.covariance.u[0]


def test_pictures_and_marks_that_contradict_are_left_out_with_the_reason():
    rng = np.random.default_rng(12)
    camera = law_camera(rng, "equidistant", widest=80.0)
    marks = marks_of(camera, held_boards(camera, rng, 12), rng)
    marks[4] = replace(marks[4], x=1.05 * marks[4].x)  # a board printed at another scale
    marks[7].u[3] += 2.0
    calibration = calibration_of(pictures_of(marks, lens="equidistant"))
    refused = {file.name: file.refused for file in calibration.files if file.refused}
    assert list(refused) == ["board 4.png"]
    assert "px (rms) from where the other pictures put them" in refused["board 4.png"]
    assert any("1 of 12 pictures were not used" in warning for warning in calibration.warnings)
    assert calibration.observations.residual.size == 2 * (11 * marks[0].u.size - 1)
    assert calibration.noise == pytest.approx(NOISE, rel=0.15)


def test_marks_of_nothing_fit_no_lens():
    rng = np.random.default_rng(13)
    x, y = (places() / SQUARE)[:, :2].T
    marks = [BoardMarks(*(rng.uniform(0, side, x.size) for side in SIZE), x, y, NOISE, 0.9) for _ in range(8)]
    with pytest.raises(InputError, match=r"target.toml: .*(no lens model fits|contradict the others).*square"):
        calibration_of(pictures_of(marks, lens="equidistant"))


def boards_at(camera, tilt, count=10):
    """Poses of boards all square to the camera's axis but for `tilt` [deg], at several distances and places."""
    rng, found = np.random.default_rng(14), []
    while len(found) < count:
        distance = rng.uniform(0.3, 0.6)
        pose = Pose.from_roll_pitch_yaw(rng.uniform(-3, 3), *np.radians(rng.uniform(-tilt, tilt, 2)))
        at = np.array([*rng.uniform(-0.2, 0.2, 2), distance]) - pose.rotation @ places().mean(axis=0)
        pose = Pose(pose.rotation, at)
        u, v = camera.project(pose.apply(places()))
        if min(u.min(), v.min(), SIZE[0] - u.max(), SIZE[1] - v.max()) > 10:
            found.append(pose)
    return found


def test_pictures_that_tell_nothing_new_are_refused():
    rng = np.random.default_rng(15)
    camera = law_camera(rng, "perspective", widest=40.0)
    poses = held_boards(camera, rng, 3)
    for few in (poses[:1] * 9, poses[:2] * 5):
        with pytest.raises(InputError, match=r"pose.*cannot be told apart.*tilted by 20 to 45 deg"):
            calibration_of(pictures_of(marks_of(camera, few, rng), lens="perspective"))
    with pytest.raises(InputError, match=r"3 usable photographs.*at least 4"):
        calibration_of(pictures_of(marks_of(camera, poses, rng)))


@pytest.mark.parametrize("law", ["perspective", "equidistant"])
def test_boards_parallel_to_each_other_are_refused_naming_the_correlation(law):
    rng = np.random.default_rng(16)
    camera = law_camera(rng, law, widest=45.0)
    marks = marks_of(camera, boards_at(camera, 0.5), rng)
    with pytest.raises(InputError, match=r"correlation (1\.0000|0\.999\d)") as refusal:
        calibration_of(pictures_of(marks, lens=law))
    assert re.search(r"(one tilt, within|at most) [0-5](\.\d)? deg", str(refusal.value))


def test_boards_hardly_tilted_leave_k_too_loose_and_are_refused():
    rng = np.random.default_rng(17)
    camera = law_camera(rng, "perspective", widest=40.0)
    marks = marks_of(camera, boards_at(camera, 3.0), rng, noise=1.0)
    with pytest.raises(InputError, match=r"known to .* px only: it cannot be told apart from the .*correlation 0\.9"):
        calibration_of(pictures_of(marks, lens="perspective"))


def test_a_law_that_carries_the_answer_alone_is_told():
    """Boards that are hardly tilted: k follows from the lens being exactly equidistant, from nothing else."""
    rng = np.random.default_rng(18)
    camera = law_camera(rng, "equidistant", widest=80.0)
    calibration = calibration_of(pictures_of(marks_of(camera, boards_at(camera, 2.5), rng)))
    if recommended(calibration).model == "equidistant":
        assert any("k rests on the lens following its law" in warning for warning in calibration.warnings)
    else:
        assert calibration.covariance.u[0] > 0.003 * camera.lens.k


def test_what_the_boards_do_not_cover_is_told():
    rng = np.random.default_rng(19)
    camera = law_camera(rng, "equidistant", widest=80.0)
    middle = [pose for pose in held_boards(camera, rng, 60) if pose.apply(places())[:, 2].min() > 0.1]
    near = [pose for pose in middle if _widest(pose) < np.radians(45)][:10]
    calibration = calibration_of(pictures_of(marks_of(camera, near, rng), lens="equidistant"))
    low, high = np.degrees(calibration.valid.zenith)
    assert low == 0
    assert high < 46
    assert any(f"boards cover zenith 0-{high:.0f} deg, the picture sees to" in said for said in calibration.warnings)


def _widest(pose):
    points = pose.apply(places())
    return np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2]).max()


def test_poses_count_as_one_when_they_hardly_differ():
    rng = np.random.default_rng(20)
    pose = np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.5])
    turned, moved = np.eye(6)[0] * 0.2, np.eye(6)[3] * 0.1
    assert distinct_poses(pose + 1e-3 * rng.standard_normal((9, 6))) == 1
    assert distinct_poses(np.stack([pose, pose + turned, pose + moved])) == 3


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"squares": (8, 6)}, "give corners"),
        ({"kind": "charuco"}, "marker"),
        ({"kind": "circle-grid", "corners": None, "squares": (8, 6)}, "count the dots"),
        ({"lens": "fisheye"}, "not known"),
        ({"square": "-24 mm"}, "greater than 0"),
    ],
)
def test_a_wrong_target_file_is_named(said, reason):
    table = {
        "format": "calibore-target/1",
        "kind": "chessboard",
        "images": "*.png",
        "square": "24 mm",
        "corners": (7, 5),
    }
    with pytest.raises(ValueError, match=reason):
        BoardTargetFile.model_validate({key: value for key, value in (table | said).items() if value is not None})

"""From a folder of photographs to a calibration: the whole way, with pictures that cannot be used among them."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from simulated_boards import CORNERS, SIZE, SQUARE, held_boards, places

from calibore.calibration import calibrate, calibrate_boards, read_calibration, write_calibration
from calibore.calibration._boards._pictures import read_board_pictures
from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.simulation import Sensor, photograph_board, unknown_fisheye
from calibore.targets import find_board

pytest.importorskip("cv2")

SENSOR = Sensor(speckle_contrast=0.0)
BLURRED, OUTSIDE, EMPTY = 3, 6, 8


def photographed(camera, pose, rng, *, kind="chessboard", sensor=SENSOR):
    return photograph_board(camera, pose, kind=kind, corners=CORNERS, square=SQUARE, sensor=sensor, rng=rng)


def target(folder, *, kind="chessboard", more=""):
    folder.joinpath("target.toml").write_text(
        f'format = "calibore-target/1"\nkind = "{kind}"\nimages = "*.png"\nsquare = "{SQUARE * 1000} mm"\n'
        f'corners = [{CORNERS[0]}, {CORNERS[1]}]\nflatness = "0 mm"\n{more}'
    )


@pytest.fixture(scope="module")
def survey(tmp_path_factory):
    """A lens that no law fits, photographs of a chessboard, one blurred, one outside the frame, one of nothing."""
    folder, rng = tmp_path_factory.mktemp("boards"), np.random.default_rng(21)
    camera = unknown_fisheye(*SIZE, rng=rng, widest=1.5)
    poses = held_boards(camera, rng, 11, margin=16)
    for number, pose in enumerate(poses):
        if number == OUTSIDE:
            pose = _pushed_out(camera, pose)
        sensor = replace(SENSOR, psf_sigma=3.0) if number == BLURRED else SENSOR
        image = photographed(camera, pose, rng, sensor=sensor)
        image = np.full_like(image, 90) if number == EMPTY else image
        Image.fromarray(image).save(folder / f"board {number:02d}.png")
    target(folder)
    calls = []
    calibration = calibrate_boards(folder, progress=lambda done, total: calls.append((done, total)))
    return camera, poses, calibration, calls, folder


def _pushed_out(camera, pose):
    """The board moved so that half of it leaves the picture."""
    middle = pose.apply(places().mean(axis=0))
    edge = camera.unproject([camera.width - 4.0], [camera.height / 2]).direction[0]
    return Pose(pose.rotation, pose.translation - middle + edge * np.linalg.norm(middle))


def test_residuals_are_no_larger_than_the_scatter_of_corners_about_the_truth(survey):
    camera, poses, calibration, *_ = survey
    rng, squares = np.random.default_rng(22), []
    for pose in (poses[0], poses[2], poses[5]):
        true = np.stack(camera.project(pose.apply(places())), axis=1)
        for _ in range(2):
            marks = find_board(photographed(camera, pose, rng), kind="chessboard", corners=CORNERS)
            found = np.column_stack([marks.u, marks.v])
            gaps = np.linalg.norm(found[:, None] - true[None], axis=2)
            squares.append(np.mean((found - true[np.argmin(gaps, axis=1)]) ** 2))
    noise = np.sqrt(np.mean(squares))
    chosen = next(row for row in calibration.models if row.remark == "recommended")
    assert noise < 0.02
    assert chosen.rmse <= 1.1 * noise
    assert chosen.model.startswith("polynomial") or "+ c1" in chosen.model


def test_pictures_that_cannot_be_used_are_listed_with_the_reason(survey):
    refused = {file.name: file.refused for file in survey[2].files if file.refused}
    assert len(survey[2].files) == 11
    assert set(refused) == {f"board {number:02d}.png" for number in (BLURRED, OUTSIDE, EMPTY)}
    assert refused[f"board {BLURRED:02d}.png"].startswith("blurred: its edges are 3.0 px wide")
    assert "chessboard of 7 x 5 corners" in refused[f"board {OUTSIDE:02d}.png"]
    assert all(len(file.sha256) == 64 for file in survey[2].files)


def test_progress_runs_to_its_end(survey):
    done, total = np.array(survey[3]).T
    assert (np.diff(done) >= 0).all()
    assert done[-1] == total[-1]
    assert len(set(total)) == 1


def test_the_lens_found_is_the_lens_within_what_is_stated(survey):
    camera, _, calibration, *_ = survey
    zenith = np.linspace(0.05, 1.0, 12) * calibration.valid.zenith[1]
    points = np.column_stack([0 * zenith, np.sin(zenith), np.cos(zenith)])
    image = calibration.camera.project_with_sensitivities(points)
    index = [calibration.camera.parameter_names.index(name) for name in calibration.values]
    rows = image.by_parameters[:, 1, index]
    u = np.sqrt(np.einsum("ni,ij,nj->n", rows, calibration.covariance.matrix, rows))
    assert (np.abs(image.v - camera.project(points)[1]) < 5 * u).all()  # the finder's own error, 0.003 px, is no chance
    assert u.max() < 0.1


def test_the_calibration_survives_its_file(survey, tmp_path):
    calibration, folder = survey[2], survey[4]
    write_calibration(calibration, tmp_path / "lens.toml")
    again = read_calibration(tmp_path / "lens.toml")
    assert again.values == pytest.approx(calibration.values)
    np.testing.assert_allclose(again.covariance.matrix, calibration.covariance.matrix, rtol=1e-9)
    assert [file.sha256 for file in again.files] == [file.sha256 for file in calibration.files]
    with pytest.raises(InputError, match="calibrate lens"):
        calibrate("rig", folder)


def test_dots_lead_to_the_same_lens_once_their_images_are_centred(tmp_path):
    """Centroids lie up to 0.2 px off the centres' images; left there, residuals would be many times the noise."""
    rng = np.random.default_rng(23)
    camera = unknown_fisheye(*SIZE, rng=rng, widest=1.2)
    for number, pose in enumerate(held_boards(camera, rng, 8, margin=20, kind="circle-grid")):
        Image.fromarray(photographed(camera, pose, rng, kind="circle-grid")).save(tmp_path / f"dots {number}.png")
    target(tmp_path, kind="circle-grid", more='lens = "polynomial"\n')
    calibration = calibrate_boards(tmp_path)
    stated = np.median([marks.sigma for marks in read_board_pictures(tmp_path).marks])
    assert calibration.noise < 1.5 * stated < 0.03
    assert abs(calibration.values["camera.k"] - camera.lens.k) < 5 * calibration.covariance.u[0]


def test_pictures_of_two_sizes_are_refused_naming_both(tmp_path):
    rng = np.random.default_rng(24)
    for number, size in enumerate([(320, 240), (320, 240), (240, 320)]):
        Image.fromarray(rng.integers(0, 255, size[::-1]).astype(np.uint8)).save(tmp_path / f"board {number}.png")
    target(tmp_path)
    with pytest.raises(InputError, match=r"board 0.png is 320 x 240 px, but board 2.png is 240 x 320 px"):
        calibrate_boards(tmp_path)


def test_a_folder_without_the_board_is_refused_with_the_first_reason(tmp_path):
    target(tmp_path)
    with pytest.raises(InputError, match=r'images = "\*.png" matches no file'):
        calibrate_boards(tmp_path)
    text = (tmp_path / "target.toml").read_text()
    (tmp_path / "target.toml").write_text(text.replace("*.png", "/pictures/*.png"))
    with pytest.raises(InputError, match="relative to target"):
        calibrate_boards(tmp_path)
    target(tmp_path)
    Image.fromarray(np.full((120, 160), 90, dtype=np.uint8)).save(tmp_path / "a.png")
    (tmp_path / "b.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"no photograph shows the board. a.png: no chessboard of 7 x 5 corners"):
        calibrate_boards(tmp_path)

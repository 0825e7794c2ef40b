"""Boards in rendered pictures: where their marks are, how well, and why there are none."""

import re
import sys

import numpy as np
import pytest

from calibore.errors import ImageError, InputError
from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.simulation import Sensor, photograph_board
from calibore.targets import Board, charuco_drawing, find_board

cv2 = pytest.importorskip("cv2")

SIZE = (640, 480)
CAMERA = Camera(*SIZE, Lens("equidistant", 330.0, 240.0), (322.0, 237.0))
SENSOR = Sensor(speckle_contrast=0.0)
CORNERS, SQUARE = (7, 5), 0.024
DOTS = {"circle-grid": ((7, 5), 0.024), "asymmetric-circle-grid": ((4, 9), 0.014)}
POSES = [(0.4, 0.25, 0.1), (-1.9, -0.3, 0.3), (2.8, 0.1, -0.35)]


def held(roll, pitch, yaw, *, at=(0.0, 0.0, 0.16), corners=CORNERS, square=SQUARE, kind="chessboard"):
    """A board whose middle is at `at` [m]."""
    places = Board(kind, corners).places * square
    middle = np.append((places.max(axis=0) + places.min(axis=0)) / 2, 0.0)
    rotation = Pose.from_roll_pitch_yaw(roll, pitch, yaw).rotation
    return Pose(rotation, np.array(at) - rotation @ middle)


def photographed(pose, seed=0, *, kind="chessboard", corners=CORNERS, square=SQUARE, sensor=SENSOR, camera=CAMERA):
    rng = np.random.default_rng(seed)
    return photograph_board(camera, pose, kind=kind, corners=corners, square=square, sensor=sensor, rng=rng)


def true_pixels(pose, *, kind="chessboard", corners=CORNERS, square=SQUARE):
    places = Board(kind, corners).places
    return np.stack(CAMERA.project(pose.apply(np.column_stack([places * square, 0 * places[:, 0]]))), axis=1)


def errors(marks, true):
    """From each mark to the nearest true one (n, 2): a chessboard may be read from either end."""
    found = np.stack([marks.u, marks.v], axis=1)
    gaps = found[:, None] - true[None]
    nearest = np.argmin(np.linalg.norm(gaps, axis=2), axis=1)
    assert np.unique(nearest).size == len(found)
    return gaps[np.arange(len(found)), nearest]


@pytest.mark.parametrize("kind", ["chessboard", "charuco"])
def test_corners_lie_where_they_are_within_what_is_stated(kind):
    found, stated = [], []
    for number, pose in enumerate(POSES):
        marks = find_board(photographed(held(*pose), number, kind=kind), kind=kind, corners=CORNERS)
        found.append(errors(marks, true_pixels(held(*pose))))
        stated.append(marks.sigmas)
    error, sigma = np.concatenate(found), np.concatenate(stated)
    assert np.sqrt(np.mean(error**2)) < 0.015  # px; OpenCV's own leave 0.05
    assert 0.7 < np.sqrt(np.mean((error / sigma[:, None]) ** 2)) < 1.5
    assert np.abs(error / sigma[:, None]).max() < 6


def test_our_corners_are_several_times_nearer_than_opencv_s():
    pose = held(*POSES[1])
    image, true = photographed(pose), true_pixels(pose)
    ours = errors(find_board(image, kind="chessboard", corners=CORNERS), true)
    found, corners = cv2.findChessboardCornersSB(image, CORNERS, flags=cv2.CALIB_CB_ACCURACY)
    theirs = np.asarray(corners, dtype=float).reshape(-1, 2)
    nearest = np.argmin(np.linalg.norm(theirs[:, None] - true[None], axis=2), axis=1)
    assert found
    assert 3 * np.sqrt(np.mean(ours**2)) < np.sqrt(np.mean((theirs - true[nearest]) ** 2))


@pytest.mark.parametrize("kind", DOTS)
def test_dots_scatter_as_stated(kind):
    corners, square = DOTS[kind]
    pose = held(0.3, 0.2, -0.2, kind=kind, corners=corners, square=square)
    pictures = [photographed(pose, seed, kind=kind, corners=corners, square=square) for seed in range(8)]
    marks = [find_board(picture, kind=kind, corners=corners) for picture in pictures]
    places = np.array([[one.u, one.v] for one in marks])
    scatter = np.sqrt(np.mean(np.var(places, axis=0, ddof=1)))
    assert scatter < 0.03
    assert np.sqrt(np.mean(marks[0].sigmas ** 2)) == pytest.approx(scatter, rel=0.3)  # black is quieter than paper
    assert np.median([one.dot for one in marks]) == pytest.approx(0.5, rel=0.05)
    true = true_pixels(pose, kind=kind, corners=corners, square=square)
    assert np.abs(errors(marks[0], true)).max() < 0.5  # centroids are not centres; the solver knows


def test_every_mark_is_numbered_by_its_place_on_the_board():
    """Where the pattern tells the ends apart, from any side: ChArUco and asymmetric dots."""
    for kind, (corners, square) in {"charuco": (CORNERS, SQUARE), "asymmetric-circle-grid": ((4, 9), 0.014)}.items():
        for roll in (0.2, 1.8, 3.3, -1.4):
            pose = held(roll, 0.15, 0.1, kind=kind, corners=corners, square=square)
            image = photographed(pose, kind=kind, corners=corners, square=square)
            marks = find_board(image, kind=kind, corners=corners)
            places = np.column_stack([marks.x, marks.y, 0 * marks.x]) * square
            u, v = CAMERA.project(pose.apply(places))
            assert np.hypot(marks.u - u, marks.v - v).max() < 0.5, kind


@pytest.mark.parametrize("kind", ["chessboard", "circle-grid"])
def test_marks_run_as_on_a_board_seen_from_the_front(kind):
    """Right-handed, turned or mirrored: a chessboard looks the same in a mirror."""
    image = photographed(held(0.4, 0.2, 0.1), kind=kind)
    for seen in (image, np.rot90(image), image[::-1, ::-1], image[:, ::-1]):
        marks = find_board(np.ascontiguousarray(seen), kind=kind, corners=CORNERS)
        design = np.column_stack([marks.x, marks.y, np.ones(marks.x.size)])
        steps = np.linalg.lstsq(design, np.column_stack([marks.u, marks.v]))[0]
        assert np.linalg.det(steps[:2]) > 0


def test_a_charuco_board_may_run_out_of_the_picture():
    pose = held(0.2, 0.0, 0.2, at=(0.14, 0.02, 0.14))
    true = true_pixels(pose)
    outside = true[:, 0] > SIZE[0] - 1
    marks = find_board(photographed(pose, kind="charuco"), kind="charuco", corners=CORNERS)
    assert outside.any()
    assert 8 <= marks.u.size < (~outside).sum() + 1
    assert np.abs(errors(marks, true)).max() < 0.1


@pytest.mark.parametrize("psf", [0.6, 1.0, 2.0])
def test_blur_is_measured(psf):
    blurred = Sensor(speckle_contrast=0.0, psf_sigma=psf)
    expected = np.hypot(psf, np.sqrt(1 / 12))  # the pixel's own area blurs too
    for kind, tolerance in (("chessboard", 0.04), ("charuco", 0.08), ("circle-grid", 0.15)):
        marks = find_board(photographed(held(0.3, 0.1, 0.1), kind=kind, sensor=blurred), kind=kind, corners=CORNERS)
        assert marks.blur == pytest.approx(expected, rel=tolerance), kind


def test_sixteen_bits_and_colours_are_read_alike():
    deep = Sensor(speckle_contrast=0.0, bits=16)
    image = photographed(held(*POSES[0]), sensor=deep) // 8
    grey = find_board(image, kind="chessboard", corners=CORNERS)
    colour = find_board(np.repeat(image[:, :, None], 3, axis=2), kind="chessboard", corners=CORNERS)
    np.testing.assert_allclose(grey.u, colour.u, atol=1e-6)
    assert np.abs(errors(grey, true_pixels(held(*POSES[0])))).max() < 0.1


def refusal(image, **said):
    with pytest.raises(ImageError) as error:
        find_board(image, **({"kind": "chessboard", "corners": CORNERS} | said))
    return str(error.value)


def test_a_board_that_is_not_wholly_in_the_picture_is_refused_with_the_side():
    image = photographed(held(0.1, 0.0, 0.0, at=(0.15, 0.0, 0.16)))
    assert "runs out of the picture at the right" in refusal(image)
    assert "runs out of the picture at the left" in refusal(np.ascontiguousarray(image[:, ::-1]))


def test_a_mirrored_photograph_is_told_where_the_pattern_can_tell():
    image = photographed(held(0.4, 0.2, 0.1), kind="charuco")
    assert "mirrored" in refusal(np.ascontiguousarray(image[:, ::-1]), kind="charuco")


def test_wrong_counts_and_empty_pictures_are_told():
    image = photographed(held(0.4, 0.2, 0.1))
    assert re.search("5 x 7|7 x 5", refusal(image, corners=(9, 6)))
    noise = np.random.default_rng(0).integers(90, 110, SIZE[::-1]).astype(np.uint8)
    for kind in ("chessboard", "charuco", "circle-grid", "asymmetric-circle-grid"):
        assert "found" in refusal(noise, kind=kind)


def test_a_board_that_cannot_be_is_refused():
    wrong = [
        {"kind": "checkers", "corners": (7, 5)},
        {"kind": "chessboard", "corners": (2, 5)},
        {"kind": "charuco", "corners": (7, 5), "marker": 1.2},
        {"kind": "circle-grid", "corners": (7, 5), "dot": 1.0},
    ]
    for said in wrong:
        with pytest.raises(InputError):
            Board(**said)
    with pytest.raises(InputError, match="dictionary"):
        charuco_drawing(Board("charuco", (7, 5), dictionary="3x3"), pixels=20)
    with pytest.raises(InputError, match="markers"):
        charuco_drawing(Board("charuco", (30, 30), dictionary="4x4_50"), pixels=20)


def test_without_opencv_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(InputError, match=r'pip install "calibore\[targets\]"'):
        find_board(np.zeros((60, 80), dtype=np.uint8), kind="chessboard", corners=CORNERS)

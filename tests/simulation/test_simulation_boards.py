"""Photographs of boards: light where the board says, through any lens, as a finer rendering has it."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.simulation import Sensor, photograph_board, unknown_fisheye
from calibore.simulation import _board_target as rendering
from calibore.targets import Board

PERFECT = Sensor.perfect()
SQUARE = 0.02


def held(kind, corners, *, turn=(0.3, 0.2, -0.15), distance=0.2):
    places = Board(kind, corners).places * SQUARE
    middle = np.append(places.mean(axis=0), 0.0)
    rotation = Pose.from_roll_pitch_yaw(*turn).rotation
    return Pose(rotation, np.array([0.0, 0.0, distance]) - rotation @ middle)


def picture(camera, pose, kind, corners, *, sensor=PERFECT, seed=0, shading=0.0):
    rng = np.random.default_rng(seed)
    return photograph_board(
        camera, pose, kind=kind, corners=corners, square=SQUARE, sensor=sensor, rng=rng, shading=shading
    )


def light_at(image, camera, points):
    u, v = (np.rint(part).astype(int) for part in camera.project(points))
    return image[v, u] / 65535


CAMERA = Camera(320, 240, Lens("equidistant", 260.0, 120.0), (161.0, 118.0))


def test_squares_alternate_and_the_first_corner_has_white_to_its_right_and_below():
    pose, corners = held("chessboard", (5, 4)), (5, 4)
    image = picture(CAMERA, pose, "chessboard", corners)
    column, row = np.meshgrid(np.arange(-1, 5), np.arange(-1, 4))
    centres = np.stack([column + 0.5, row + 0.5, 0.0 * row], axis=-1).reshape(-1, 3) * SQUARE
    white = (column + row).ravel() % 2 == 0
    expected = np.where(white, rendering.WHITE, rendering.BLACK)
    np.testing.assert_allclose(light_at(image, CAMERA, pose.apply(centres)), expected, atol=2e-3)


@pytest.mark.parametrize(("kind", "corners"), [("circle-grid", (5, 4)), ("asymmetric-circle-grid", (3, 6))])
def test_dots_are_black_on_white_paper(kind, corners):
    pose = held(kind, corners, distance=0.25)
    image = picture(CAMERA, pose, kind, corners)
    places = Board(kind, corners).places
    dots = np.column_stack([places, 0 * places[:, 0]]) * SQUARE
    np.testing.assert_allclose(light_at(image, CAMERA, pose.apply(dots)), rendering.BLACK, atol=0.02)
    between = dots + np.array([0.5, 0.5, 0.0] if kind == "circle-grid" else [1.0, 0.0, 0.0]) * SQUARE
    np.testing.assert_allclose(light_at(image, CAMERA, pose.apply(between)), rendering.WHITE, atol=0.02)


@pytest.mark.parametrize("kind", ["chessboard", "circle-grid", "charuco"])
def test_edges_are_as_in_a_much_finer_rendering(kind, monkeypatch):
    if kind == "charuco":
        pytest.importorskip("cv2")
    pose = held(kind, (5, 4))
    coarse = picture(CAMERA, pose, kind, (5, 4)) / 65535
    monkeypatch.setattr(rendering, "FINENESS", 11)
    fine = picture(CAMERA, pose, kind, (5, 4)) / 65535
    assert np.abs(coarse - fine).max() < 0.02  # of one pixel at the rim of a marker
    assert np.abs((coarse - fine).mean()) < 1e-4


def test_a_board_beyond_ninety_degrees_is_seen_by_a_lens_that_sees_there():
    camera = Camera(320, 240, Lens("equidistant", 80.0, 120.0), (160.0, 120.0))
    towards = np.array([np.sin(1.75), 0.0, np.cos(1.75)])
    rotation = np.stack([np.cross([0.0, 1.0, 0.0], towards), [0.0, 1.0, 0.0], towards], axis=1)
    rotation[:, 0] /= np.linalg.norm(rotation[:, 0])
    rotation[:, 1] = np.cross(towards, rotation[:, 0])
    pose = Pose(rotation, 0.15 * towards)
    image = picture(camera, pose, "circle-grid", (5, 4))
    white = light_at(image, camera, pose.apply(np.array([[0.5, 0.5, 0.0]]) * SQUARE))
    assert pose.translation[2] < 0
    np.testing.assert_allclose(white, rendering.WHITE, atol=0.02)


def test_the_same_chance_gives_the_same_bytes():
    pose, sensor = held("chessboard", (5, 4)), Sensor(speckle_contrast=0.0)
    first, again, other = (picture(CAMERA, pose, "chessboard", (5, 4), sensor=sensor, seed=seed) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes() != other.tobytes()
    assert first.shape == (240, 320)


def test_no_law_fits_an_unknown_fisheye():
    """The best k of each law leaves image radii that no corner finder would miss."""
    for seed in range(5):
        lens = unknown_fisheye(1280, 960, rng=np.random.default_rng(seed)).lens
        zenith = np.linspace(0.02, 1.5, 200)
        radius = lens.image_radius(zenith)
        assert (np.diff(radius) > 0).all()
        for law in LENS_LAWS.values():
            ratio = law.ratio(zenith)
            k = ratio @ radius / (ratio @ ratio)
            assert np.sqrt(np.mean((radius - k * ratio) ** 2)) > 0.5
        powers = zenith[:, None] ** np.arange(1, 10, 2)
        rest = radius - powers @ np.linalg.lstsq(powers, radius)[0]
        assert 1e-4 < np.abs(rest).max() < 0.2  # nor quite the polynomials that are tried


def test_a_walking_pupil_is_refused():
    walking = Camera(320, 240, CAMERA.lens, CAMERA.principal_point, pupil_walk=(1e-3,))
    with pytest.raises(InputError, match="entrance pupil"):
        picture(walking, held("chessboard", (5, 4)), "chessboard", (5, 4))

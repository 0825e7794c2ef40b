"""Marks lie where the ink is, with the uncertainty they state, on the ring whose number they bear."""

import json
from pathlib import Path

import numpy as np
import pytest
from ring_pictures import INCH, Photograph, random_photograph, target_pose

from calibore.geometry import Pose
from calibore.images import read_image
from calibore.optics import Camera, Lens
from calibore.simulation import Sensor, TargetLight
from calibore.targets import find_rings

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"


@pytest.fixture(scope="module")
def noisy():
    """Photographs of all kinds, their marks and the marks' errors."""
    rng = np.random.default_rng(8)
    photographs = [random_photograph(rng) for _ in range(3)]
    found = [find_rings(one.image, rings=one.rings, spokes=one.spokes) for one in photographs]
    return [(one, marks, one.errors_of(marks)) for one, marks in zip(photographs, found, strict=True)]


def sine_camera(k=360.0):
    return Camera(640, 480, Lens("sine-law", k, 240.0), (322.0, 237.0))


def test_without_noise_marks_are_midway_between_the_edges_of_the_ink():
    """Strong blur and a steep slope of the light, which shift what is seen of a line, included."""
    camera = sine_camera()
    pose = target_pose(camera, centre=(290, 262), distance=9 * INCH, tilt=0.1, towards=1.0, turn=0.4)
    light = TargetLight(0.6, 0.6, 0.8, 2.0)
    sensor = Sensor(psf_sigma=1.2, speckle_contrast=0, full_well=np.inf, read_noise=0, background=0, bits=16)
    one = Photograph(camera, pose, sensor=sensor, rng=np.random.default_rng(0), light=light)
    marks = find_rings(one.image, rings=12, spokes=8)
    error = one.errors_of(marks)
    means = [error[marks.ring == ring].mean() for ring in np.unique(marks.ring)]
    assert np.abs(means).max() < 1e-3  # blur alone would shift ring 1 by 0.01 px
    assert np.abs(error).max() < 0.01  # a tenth of the noise of a picture with 8 bit


def test_stated_uncertainty_is_the_scatter_of_the_marks(noisy):
    for _, marks, error in noisy:
        pull = error / marks.sigma
        assert 0.93 < pull.std() < 1.07  # 3000 marks and more: sampling scatter 0.013
        assert np.mean(np.abs(pull) > 1.96) == pytest.approx(0.05, abs=0.015)
        assert np.abs(pull).max() < 6


def test_no_ring_is_shifted(noisy):
    for _, marks, error in noisy:
        for ring in np.unique(marks.ring[marks.ring > 0]):
            member = marks.ring == ring
            least = np.sqrt(np.mean(marks.sigma[member] ** 2) / member.sum())
            assert abs(error[member].mean()) < 0.003 + 4 * least


def test_neighbouring_marks_share_no_noise(noisy):
    for _, marks, error in noisy:
        pull = error / marks.sigma
        pairs = (marks.ring[1:] == marks.ring[:-1]) & (marks.spoke[1:] == marks.spoke[:-1])
        assert abs(np.mean((pull[1:] * pull[:-1])[pairs])) < 4 / np.sqrt(pairs.sum()) + 0.02


def test_every_mark_bears_the_number_of_its_ring(noisy):
    """An error of one ring would be an error of many pixels."""
    for one, marks, error in noisy:
        assert np.abs(error).max() < 0.5
        counted = np.unique(marks.ring[marks.ring > 0])
        assert counted.tolist() == list(range(1, counted.size + 1))
        assert one.rings - counted.size <= 2  # the outermost may be too near the paper's edge


def test_spokes_are_numbered_round_the_centre_where_they_meet(noisy):
    for one, marks, _ in noisy:
        centre = one.camera.project(one.pose.inverse().apply(np.zeros((1, 3))))
        assert np.hypot(centre[0][0] - marks.centre[0], centre[1][0] - marks.centre[1]) < 0.3
        azimuth = np.arctan2(marks.v - marks.centre[1], marks.u - marks.centre[0]) % (2 * np.pi)
        first = [azimuth[marks.spoke == spoke][0] for spoke in np.unique(marks.spoke[marks.spoke >= 0])]
        assert np.all(np.diff(first) > 0)


def test_the_width_of_the_ink_is_measured(noisy):
    for one, marks, _ in noisy:
        edges = [one._edge(marks, side * one.ink / 2) for side in (-1, 1)]
        assert np.median(marks.width / np.abs(edges[1] - edges[0])) == pytest.approx(1, abs=0.1)


def test_rings_too_close_to_be_resolved_are_left_out_and_named():
    camera = sine_camera(k=250.0)
    pose = target_pose(camera, centre=(324, 239), distance=3.5 * INCH)
    one = Photograph(camera, pose, sensor=Sensor(psf_sigma=0.8), rng=np.random.default_rng(4))
    marks = find_rings(one.image, rings=12, spokes=8)
    last = int(marks.ring.max())
    assert 5 <= last <= 8  # 8 and 9 are 4 px apart: 5 blurs
    assert marks.left_out.startswith(f"Rings {last + 1}, ")
    assert np.abs(one.errors_of(marks)).max() < 0.5


def test_grey_and_colour_and_eight_and_sixteen_bits_agree():
    camera = sine_camera()
    pose = target_pose(camera, centre=(320, 240), distance=12 * INCH, turn=0.3)
    one = Photograph(camera, pose, sensor=Sensor(psf_sigma=0.8, bits=16), rng=np.random.default_rng(5))
    first = find_rings(one.image, rings=12, spokes=8)
    other = find_rings((one.image[..., 1] // 257).astype(np.uint8), rings=12, spokes=8)
    for marks, most in ((first, 6), (other, 6)):
        assert np.abs(one.errors_of(marks) / marks.sigma).max() < most
    assert other.sigma.mean() > 1.3 * first.sigma.mean()  # one channel of three


@pytest.mark.parametrize("name", ["rings-3in", "rings-30in"])
def test_shared_photographs_show_rings_where_their_cameras_put_them(name):
    if not SHARED.exists():
        pytest.skip("the shared photographs are not beside the repository")
    case = json.loads((SHARED / name / "case.json").read_text())
    camera = Camera(1024, 768, Lens("sine-law", case["camera"]["k_px"], 384.0), (512.0, 384.0))
    rotation, _, turned = np.linalg.svd(case["camera_pose_in_target"]["R"])
    pose = Pose(rotation @ turned, np.array(case["camera_pose_in_target"]["t"]) * INCH)
    one = Photograph.__new__(Photograph)
    one.camera, one.pose, one.spacing, one.ink = camera, pose, INCH, 0.06 * INCH
    one.rings, one.spokes, one.errors = 12, 8, np.zeros(12)
    marks = find_rings(read_image(next((SHARED / name).glob("*.png"))), rings=12, spokes=8)
    error = one.errors_of(marks)
    assert marks.ring.max() >= 9
    for ring in np.unique(marks.ring):
        member = marks.ring == ring
        assert abs(error[member].mean()) < 0.003 + 4 * error[member].std() / np.sqrt(member.sum())
    assert np.sqrt(np.mean(error**2)) < 0.06  # these pictures place edges in steps of a quarter pixel

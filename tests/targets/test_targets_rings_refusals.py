"""Photographs that cannot be used are refused with a sentence that says why and what to do."""

import numpy as np
import pytest
from ring_pictures import INCH, Photograph, target_pose
from scipy.ndimage import gaussian_filter

from calibore.errors import ImageError
from calibore.optics import Camera, Lens
from calibore.simulation import Sensor, TargetLight
from calibore.targets import find_rings

CAMERA = Camera(640, 480, Lens("sine-law", 360.0, 240.0), (322.0, 237.0))
POSE = target_pose(CAMERA, centre=(328, 240), distance=13 * INCH, tilt=0.05, towards=1.0, turn=0.3)
SENSOR = Sensor(psf_sigma=0.8, full_well=12000)


def photograph(**given):
    return Photograph(CAMERA, POSE, sensor=SENSOR, rng=np.random.default_rng(3), **given).image


@pytest.fixture(scope="module")
def image():
    return photograph()


def refusal(image, *, rings=12, spokes=8):
    with pytest.raises(ImageError) as refused:
        find_rings(image, rings=rings, spokes=spokes)
    sentence = str(refused.value)
    assert sentence.endswith(".")
    assert len(sentence) > 60  # what is wrong and what to do
    return sentence


@pytest.mark.parametrize(
    ("stated", "words"), [(9, "12 rings were found where 9"), (14, "12 rings were found where 14")]
)
def test_other_numbers_of_rings_than_stated(image, stated, words):
    assert words in refusal(image, rings=stated)


def test_one_ring_more_than_stated_is_a_border(image):
    assert find_rings(image, rings=11, spokes=8).ring.max() == 11


@pytest.mark.parametrize("stated", [4, 6, 9, 12])
def test_another_number_of_spokes_than_stated(image, stated):
    assert f"8 spokes were found to meet at u = 328 px, v = 240 px where {stated}" in refusal(image, spokes=stated)


@pytest.mark.parametrize("kind", ["noise", "even", "slope", "stripes"])
def test_no_target(kind):
    rng = np.random.default_rng(1)
    pictures = {
        "noise": rng.integers(20, 250, (480, 640, 3)),
        "even": np.full((480, 640), 120),
        "slope": np.tile(np.linspace(0, 200, 640), (480, 1)),
        "stripes": np.tile(np.where(np.arange(640) % 40 < 4, 30, 200), (480, 1)) + rng.normal(0, 2, (480, 640)),
    }
    sentence = refusal(pictures[kind].astype(np.uint8))
    assert "No ring target was found" in sentence or "spokes were found" in sentence


def test_too_much_and_too_little_light():
    assert "over-exposed" in refusal(photograph(light=TargetLight(exposure=1.4)))
    assert "under-exposed" in refusal(photograph(light=TargetLight(exposure=0.06)))


@pytest.mark.parametrize("blur", [4, 6, 12])
def test_out_of_focus(image, blur):
    assert "focus" in refusal(gaussian_filter(image.astype(float), (blur, blur, 0)).astype(np.uint8))


def test_a_centre_outside_the_picture(image):
    for part in (image[:, :316], image[:, 340:]):
        assert "centre lies outside the picture" in refusal(part)


def test_rings_on_one_side_only(image):
    covered = image.copy()
    covered[:, :300] = 20
    assert "spokes were found" in refusal(covered)


def test_no_picture_of_a_camera(image):
    for wrong in (image[200:380, 300:490], image.astype(float), image[0]):
        assert "needs a picture" in refusal(wrong)


def test_rings_cut_by_the_picture_are_measured_as_arcs(image):
    marks = find_rings(image[:, 200:], rings=12, spokes=8)
    assert np.unique(marks.ring).tolist() == list(range(13))
    azimuth = np.arctan2(marks.v - marks.centre[1], marks.u - marks.centre[0])
    assert np.abs(azimuth[marks.ring == 11]).max() < 2.6  # its left part is not in the picture
    assert np.abs(azimuth[marks.ring == 3]).max() > 3.0

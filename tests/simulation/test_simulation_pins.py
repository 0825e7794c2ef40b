"""Photographed pins have their edges where the camera's rays graze them."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.optics import Camera, Lens
from calibore.simulation import Pin, Sensor, TargetLight, _pin_target, photograph_pins, turntable_pose

CAMERA = Camera(640, 480, Lens("equidistant", 2000.0, 240.0), (320.0, 240.0))
NEAR, FAR = Pin(0.001, 0.13, 0.001, -0.002, 0.1, 0.2), Pin(-0.004, 0.55, 0.002, -0.1, 0.006, 0.5)
LIGHT = TargetLight(0.7, 0.0, 0.0)


def picture(pins=(NEAR, FAR), *, forward=0.016, turn=0.05):
    pose = turntable_pose(forward, turn)
    image = photograph_pins(CAMERA, pose, pins=pins, sensor=Sensor.perfect(), rng=np.random.default_rng(0), light=LIGHT)
    return image[..., 0].astype(float), pose


def grazing(pin, pose, row):
    """Columns of both edges of a pin in a row of the picture: rays tangential to its circle, seen from above."""
    eye = pose.translation
    x, z = pin.x - eye[0], pin.z - eye[2]
    edges = np.arctan2(x, z) + np.array([-1, 1]) * np.arcsin(pin.radius / np.hypot(x, z))
    column = np.arange(CAMERA.width) * 1.0
    direction = CAMERA.unproject(column, np.full(column.shape, row)).direction @ pose.rotation.T
    return np.interp(edges, np.arctan2(direction[:, 0], direction[:, 2]), column)


@pytest.mark.parametrize(("pin", "row"), [(NEAR, 400.0), (FAR, 60.0)], ids=["near", "far"])
def test_a_pin_is_as_wide_as_seen(pin, row, monkeypatch):
    monkeypatch.setattr(_pin_target, "AMBIENT", 1.0)  # a pin without shades, so that half its depth is its edge
    for forward, turn in ((0.016, 0.05), (0.001, -0.06), (0.03, 0.0)):
        image, pose = picture(forward=forward, turn=turn)
        line = image[int(row)]
        half = (1 + pin.albedo) / 2 * line.max()
        dark = np.flatnonzero(line < half)
        left, right = dark[0], dark[-1]
        seen = [
            left - (half - line[left]) / (line[left - 1] - line[left]),
            right + (half - line[right]) / (line[right + 1] - line[right]),
        ]
        assert np.allclose(seen, grazing(pin, pose, row), atol=0.02)  # linear between pixels


def test_the_near_pin_hides_the_far_one():
    image, _ = picture((NEAR, Pin(0.001, 0.55, 0.0005, -0.1, 0.1, 0.6)), forward=0.0, turn=0.0)
    alone, _ = picture((NEAR,), forward=0.0, turn=0.0)
    inside = slice(330, 340)
    assert np.allclose(image[400, inside], alone[400, inside])


def test_turning_about_the_pupil_moves_near_and_far_alike():
    """The whole idea of the fixture: at the pupil there is no parallax."""
    apart = []
    for forward in (0.0, 0.02):
        centres = [
            [np.mean(grazing(pin, turntable_pose(forward, turn), 240.0)) for pin in (NEAR, FAR)]
            for turn in (-0.05, 0.05)
        ]
        apart.append(np.diff(np.diff(centres, axis=1), axis=0).item())
    assert abs(apart[0]) < 0.05
    assert abs(apart[1]) > 5


def test_a_pin_upside_down_is_refused():
    with pytest.raises(InputError, match="top above its bottom"):
        Pin(0.0, 0.1, 0.001, 0.1, -0.1)

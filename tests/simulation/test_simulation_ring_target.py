"""A photographed ring target shows its lines where the camera sees them."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera, FlatPort, Lens
from calibore.simulation import Sensor, TargetLight, _soft_edges, photograph_rings

INCH = 0.0254
POSE = Pose.from_roll_pitch_yaw(0.4, 0.05, -0.08, translation=(0.01, -0.02, -12 * INCH))
EVEN = TargetLight(exposure=0.8, falloff=0.0, gradient=0.0)


def camera(**more):
    return Camera(640, 480, Lens("equidistant", 300.0, 240.0), (322.3, 238.1), **more)


def picture(camera, *, sensor=None, seed=0, **given):
    target = {"ring_spacing": INCH, "rings": 10, "spokes": 6, "ink_width": 0.1 * INCH, "light": EVEN} | given
    sensor = sensor or Sensor.perfect()
    return photograph_rings(camera, POSE, **target, sensor=sensor, rng=np.random.default_rng(seed))


def ring_edges(camera, radius, ink=0.1 * INCH, count=240):
    """Pixels (2, n) of both edges of a ring, away from the spokes."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False) + 0.01
    turn = turn[np.abs((turn * 6 / (2 * np.pi)) % 1 - 0.5) < 0.35]
    for offset in (-ink / 2, ink / 2):
        points = (radius + offset) * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
        yield np.stack(camera.project(POSE.inverse().apply(points)))


@pytest.mark.parametrize("more", [{}, {"pupil_walk": (0.004,)}, {"port": FlatPort(0.01, 1.5)}], ids=str)
def test_dark_lines_are_centred_midway_between_the_edges_of_their_ink(more):
    """Less what blurring a curved line shifts it towards its centre: s^2 / 2r."""
    one = camera(**more)
    image = picture(one)[..., 0].astype(float)
    centre = np.stack(one.project(POSE.inverse().apply(np.zeros((1, 3)))))
    for ring in (2, 5, 9):
        inner, outer = ring_edges(one, ring * INCH)
        middle, across = (inner + outer) / 2, (outer - inner) / np.hypot(*(outer - inner))
        along = np.linspace(-9, 9, 181)
        u, v = middle[:, :, None] + along * across[:, :, None]
        depth = image.max() - map_coordinates(image, [v, u], order=5)
        shift = -(0.9**2 + 1 / 12) / 2 / np.hypot(*(middle - centre))
        error = depth @ along / depth.sum(axis=1) - shift
        assert abs(error.mean()) < 1e-3
        assert np.abs(error).max() < 5e-3  # the ring is no circle round that centre


def test_printed_errors_move_their_ring_only():
    errors = np.zeros(10)
    errors[4] = 0.05 * INCH
    changed = np.abs(picture(camera()).astype(int) - picture(camera(), radius_errors=errors)).max(axis=2) > 50
    v, u = np.nonzero(changed)
    rays = camera().unproject(u, v)
    origin, direction = POSE.apply(rays.origin), rays.direction @ POSE.rotation.T
    radius = np.hypot(*(origin - origin[:, 2:] / direction[:, 2:] * direction)[:, :2].T) / INCH
    assert u.size > 1000
    assert 4.5 < radius.min() < radius.max() < 5.5


def test_bands_leave_no_seam(monkeypatch):
    whole = picture(camera())
    monkeypatch.setattr(_soft_edges, "BAND", 37)
    assert np.abs(whole.astype(int) - picture(camera())).max() <= 1  # of 65535: order of summation


def test_the_same_seed_gives_the_same_picture():
    first, again, other = (picture(camera(), sensor=Sensor(), seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_rings_that_overlap_cannot_be_printed():
    with pytest.raises(InputError, match="further apart than their ink"):
        picture(camera(), ink_width=1.1 * INCH)

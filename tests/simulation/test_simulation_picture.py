"""Pictures show the line where it is, with the noise that was asked for."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig
from calibore.simulation import (
    Band,
    Finish,
    Harmonic,
    LineLight,
    Ovality,
    PipeWall,
    Sensor,
    line_image,
    lit_line,
    random_pose,
    random_rig,
    render_ring,
    speckle_field,
)

R0 = 0.1524
WALL = PipeWall(R0, (Ovality((2.0, 2.0)), Harmonic(3, 3e-4)))
POSE = Pose.from_roll_pitch_yaw(0.03, 0.005, -0.01, translation=(0.004, 0.002, -0.33))


def sine_rig(scale=1.0, channel="red"):
    width, height = int(1024 * scale), int(768 * scale)
    camera = Camera(width, height, Lens("sine-law", 571.0 * scale, height / 2), (513.3 * scale, 380.6 * scale))
    return Rig("perpendicular-plane", camera, (Laser(Plane(0.33274), channel),))


def centroids(rig, lit, image, reach=7.0):
    """Centre of gravity (n,) [px outwards] of `image` along the normals of the true line."""
    run = np.stack([np.roll(lit.u, -1) - np.roll(lit.u, 1), np.roll(lit.v, -1) - np.roll(lit.v, 1)], axis=1)
    normal = np.stack([run[:, 1], -run[:, 0]], axis=1) / np.linalg.norm(run, axis=1)[:, None]
    out = np.stack([lit.u, lit.v], axis=1) - rig.camera.principal_point
    normal *= np.sign(np.sum(normal * out, axis=1))[:, None]
    t = np.linspace(-reach, reach, 141)
    place = [lit.v[:, None] + t * normal[:, 1:], lit.u[:, None] + t * normal[:, :1]]
    along = map_coordinates(image.astype(float), place, order=5)
    return along @ t / along.sum(axis=1), along.max(axis=1)


def test_the_line_is_centred_where_the_wall_is_imaged():
    """Less the shift that blurring any curved line gives it: a ring of radius r blurred by s moves inwards by s^2 / 2r,
    its thickness w by w^2 / r, because its outer half is as bright but longer.
    """
    rig = sine_rig()
    lit = lit_line(rig, WALL, pipe_from_rig=POSE, line=LineLight(), psf_sigma=0.9)
    error, peak = centroids(rig, lit, line_image(lit, (768, 1024), psf_sigma=0.9))
    radius = np.hypot(lit.u - 513.3, lit.v - 380.6)
    shift = -((0.9**2 + 1 / 12) / 2 + np.sum(lit.spread**2, axis=1)) / radius
    assert abs(error.mean()) < 0.003
    assert np.abs(error - shift).max() < 1e-3  # the wall's own curvature differs from the ring's by some percent
    assert peak == pytest.approx(lit.signal, rel=0.01)


def test_the_line_is_centred_for_random_rigs():
    rng = np.random.default_rng(5)
    for _ in range(4):
        rig = random_rig(rng, R0, width=1024, height=768)
        pose = random_pose(rng, rig, R0)
        line = LineLight(sigma=0.002 * R0)
        lit = lit_line(rig, WALL, pipe_from_rig=pose, line=line, psf_sigma=1.0)
        error, _ = centroids(rig, lit, line_image(lit, (768, 1024), psf_sigma=1.0))
        radius = np.hypot(lit.u - rig.camera.principal_point[0], lit.v - rig.camera.principal_point[1])
        shift = -((1.0 + 1 / 12) / 2 + np.sum(lit.spread**2, axis=1)) / radius
        assert abs(np.mean(error - shift)) < 5e-4


def test_without_speckle_and_noise_only_quantisation_is_left():
    rig = sine_rig(0.5)
    lit = lit_line(rig, WALL, pipe_from_rig=POSE, line=LineLight(), psf_sigma=0.9)
    image = render_ring(rig, WALL, pipe_from_rig=POSE, rng=np.random.default_rng(0), sensor=Sensor.perfect(bits=8))
    exact = 255 * line_image(lit, (384, 512), psf_sigma=0.9)
    assert image.dtype == np.uint8
    assert np.abs(image[:, :, 0] - exact).max() <= 0.5 + 1e-4
    assert np.abs(image[:, :, 1] - 0.06 * exact).max() <= 0.5 + 1e-4


def test_the_brightness_asked_for_is_the_peak_on_the_nominal_wall():
    for brightness in (0.2, 0.6):
        lit = lit_line(
            sine_rig(),
            PipeWall(R0),
            pipe_from_rig=Pose.identity(),
            line=LineLight(brightness=brightness),
            psf_sigma=0.9,
        )
        assert lit.signal == pytest.approx(brightness, rel=0.01)


def test_a_wall_turned_away_from_the_camera_is_darker():
    steep = PipeWall(R0, (Ovality((0.0, 3.0), axial=(-0.03, 0.03), axis=0.0),))
    lit = lit_line(sine_rig(), steep, pipe_from_rig=Pose(np.eye(3), [0, 0, -0.33274]), line=LineLight(), psf_sigma=0.9)
    narrowing, widening = (lit.signal[np.abs(np.sin(lit.clock - at)) < 0.05].mean() for at in (np.pi / 2, 0.0))
    assert narrowing > 1.1 * widening


def test_an_overexposed_line_saturates():
    line = LineLight(brightness=4.0)
    image = render_ring(sine_rig(0.5), WALL, pipe_from_rig=POSE, rng=np.random.default_rng(0), line=line)
    assert np.sum(image[:, :, 0] == 255) > 1000


def test_a_line_cut_off_altogether_leaves_the_background():
    dark = LineLight(shadows=((0.0, 7.0),))
    sensor = Sensor(background=20.0)
    image = render_ring(sine_rig(0.5), WALL, pipe_from_rig=POSE, rng=np.random.default_rng(0), line=dark, sensor=sensor)
    assert image.mean() == pytest.approx(20.0, abs=0.02)


def test_shot_and_read_noise_have_the_stated_size():
    sensor = Sensor(full_well=5000.0, read_noise=15.0)
    for level in (0.1, 0.7):
        image = sensor.read_out(np.full((300, 300, 3), level, dtype=np.float32), np.random.default_rng(2))
        electrons = (level + 4.0 / 255) * 5000.0
        expected = np.hypot(255 / 5000.0 * np.sqrt(electrons + 15.0**2), np.sqrt(1 / 12))
        assert image.std() == pytest.approx(expected, rel=0.01)
        assert image.mean() == pytest.approx(electrons * 255 / 5000, rel=0.001)


@pytest.mark.parametrize("contrast", [0.2, 0.5, 1.0])
def test_speckle_of_a_flat_field_has_the_stated_mean_contrast_and_grain(contrast):
    field = speckle_field((500, 700), contrast=contrast, grain=2.0, rng=np.random.default_rng(3))
    assert field.min() >= 0
    assert field.mean() == pytest.approx(1.0, abs=0.01)  # about 28 000 independent grains
    assert field.std() == pytest.approx(contrast, rel=0.03)
    normal = np.argsort(np.argsort(field.ravel())).reshape(field.shape)  # ranks undo the gamma shape
    for lag in (1, 2, 4):
        correlation = 2 * np.sin(np.pi / 6 * np.corrcoef(normal[:, lag:].ravel(), normal[:, :-lag].ravel())[0, 1])
        assert correlation == pytest.approx(np.exp(-((lag / 2.0) ** 2)), abs=0.03)


def test_takes_share_their_speckle_as_far_as_stated():
    for decorrelation in (0.0, 0.3, 1.0):
        one, two = (
            speckle_field(
                (300, 300),
                contrast=0.3,
                grain=1.5,
                rng=np.random.default_rng(take),
                shared=np.random.default_rng(9),
                decorrelation=decorrelation,
            )
            for take in (1, 2)
        )
        assert np.corrcoef(one.ravel(), two.ravel())[0, 1] == pytest.approx(1 - decorrelation, abs=0.03)


def test_the_same_generator_gives_the_same_picture():
    one, same, other = (
        render_ring(sine_rig(0.5), WALL, pipe_from_rig=POSE, rng=np.random.default_rng(seed)) for seed in (4, 4, 5)
    )
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize(("channel", "brightest"), [("red", 0), ("green", 1), ("blue", 2), (None, 0)])
def test_the_laser_shines_in_its_channel(channel, brightest):
    image = render_ring(sine_rig(0.5, channel), WALL, pipe_from_rig=POSE, rng=np.random.default_rng(0))
    assert np.argmax(image.reshape(-1, 3).astype(int).sum(axis=0)) == brightest


def test_sixteen_bits_are_finer_than_eight():
    image = render_ring(
        sine_rig(0.5), WALL, pipe_from_rig=POSE, rng=np.random.default_rng(0), sensor=replace(Sensor(), bits=16)
    )
    assert image.dtype == np.uint16
    assert len(np.unique(image)) > 1000


@pytest.mark.parametrize(
    "wrong", [{"psf_sigma": 0.1}, {"bits": 12}, {"speckle_contrast": 1.5}, {"full_well": 0.0}, {"background": -1.0}]
)
def test_an_impossible_sensor_is_refused(wrong):
    with pytest.raises(InputError):
        Sensor(**wrong)


def drawn(rig, wall, pose, leaves):
    """The line of so many leaves and its picture, without any noise."""
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=LineLight(leaves=leaves), psf_sigma=0.9)
    shape = rig.camera.height, rig.camera.width
    return lit, sum(line_image(part, shape, psf_sigma=0.9) for part in lit.imaged)


def test_the_leaves_of_a_fan_make_up_its_light():
    """Where the wall is smooth: to 1 % of the peak, for a plane and for a cone."""
    rng = np.random.default_rng(12)
    cone = random_rig(rng, R0, kind="single-cone")
    for rig, pose in [(sine_rig(), POSE), (cone, random_pose(rng, cone, R0))]:
        whole, leaves = (drawn(rig, WALL, pose, count)[1] for count in (1, 9))
        assert np.abs(leaves - whole).max() < 0.01 * whole.max()


def test_dirt_narrower_than_the_light_moves_a_line_of_many_leaves():
    """A wall that is black from the middle of the line on shows the other half of it: its mean is 0.8 sigma away."""
    black = PipeWall(R0, WALL.parts, Finish(stains=(Band((0.0, 0.1), reflectance=0.0, edge=1e-5),)))
    pose = Pose.from_roll_pitch_yaw(translation=(0.0, 0.0, -0.33274))
    (lit, clean), (_, dirty) = (drawn(sine_rig(), wall, pose, 32) for wall in (WALL, black))
    seen, half = (centroids(sine_rig(), lit, image)[0].mean() for image in (clean, dirty))
    assert dirty.sum() == pytest.approx(0.5 * clean.sum(), rel=0.02)
    assert abs(half - seen) == pytest.approx(np.linalg.norm(lit.spread, axis=1).mean() * np.sqrt(2 / np.pi), rel=0.05)

"""Dirt, water, glare: light goes where physics sends it, none comes from nothing, the truth says what is not seen."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing
from calibore.simulation import (
    RIG_KINDS,
    Band,
    Dent,
    Deposit,
    Finish,
    Ghost,
    Lamp,
    LineLight,
    Overlay,
    Patch,
    PipeWall,
    Sensor,
    Smudge,
    Specks,
    Water,
    Window,
    head_pose,
    line_image,
    lit_line,
    photograph_all,
    random_rig,
    render_ring,
    seen_through,
    true_ring,
)

R = 0.15
RIG = Rig(
    "perpendicular-plane", Camera(320, 240, Lens("sine-law", 178.0, 120.0), (158.0, 121.0)), (Laser(Plane(0.33)),)
)
WALL = PipeWall(R, (Dent(0.006, 1.0, 0.0, 0.2, 0.05),))
POSE = Pose.from_roll_pitch_yaw(0.02, 0.01, translation=(0.003, 0.002, -0.33))
LINE, SENSOR, SHAPE = LineLight(), Sensor(), (240, 320)
AXIAL, CLOCK = np.random.default_rng(1).uniform([-0.3, 0.0], [0.3, 2 * np.pi], (40000, 2)).T


def seen(wall=WALL, window=None, pose=POSE):
    lit = lit_line(RIG, wall, pipe_from_rig=pose, line=LINE, psf_sigma=0.9)
    return seen_through(lit, RIG, wall, pipe_from_rig=pose, window=window or Window())


def finished(**finish):
    return replace(WALL, finish=Finish(**finish))


def picture(wall=WALL, **more):
    rngs = {"rng": np.random.default_rng(1), "speckle_rng": np.random.default_rng(2)}
    return render_ring(RIG, wall, pipe_from_rig=POSE, line=LINE, sensor=SENSOR, **rngs, **more)


def test_the_nominal_finish_and_a_clear_window_change_no_pixel():
    assert np.array_equal(picture(), picture(finished(), window=Window()))


def test_a_black_wall_shows_no_line():
    black = seen(finished(reflectance=0.0))
    assert not black.signal.any()
    assert not line_image(black, SHAPE, psf_sigma=0.9).any()
    assert picture(finished(reflectance=0.0)).max() < 30  # background 4 of 255 and its noise
    assert picture().max() > 120


def test_a_wall_returns_in_proportion_to_its_reflectance_wherever_it_is_seen():
    plain = seen()
    for reflectance in np.random.default_rng(2).uniform(0, 3, 10):
        lit = seen(finished(reflectance=float(reflectance)))
        assert lit.signal == pytest.approx(reflectance * plain.signal, rel=1e-12)
        assert np.array_equal(lit.visible, plain.visible)


@pytest.mark.parametrize("contrast", [0.1, 0.3])
def test_a_texture_has_the_stated_contrast_and_never_returns_less_than_nothing(contrast):
    finish = Finish(reflectance=0.8, contrast=contrast, grain=0.01)
    share = finish.matt(AXIAL, CLOCK, R)
    assert share.min() >= 0
    assert share.mean() == pytest.approx(0.8, rel=0.03)  # 90 x 60 grains
    assert share.std() / share.mean() == pytest.approx(contrast, rel=0.08)
    near, far = (np.corrcoef(share, finish.matt(AXIAL + step, CLOCK, R))[0, 1] for step in (0.002, 0.05))
    assert near > 0.9
    assert abs(far) < 0.1


def test_a_sheen_is_the_same_with_light_and_eye_exchanged_and_gives_back_no_more_than_it_takes():
    rng = np.random.default_rng(3)
    for gloss in (5.0, 50.0, 500.0):
        finish = Finish(reflectance=0.0, specular=1.0, gloss=gloss)
        point, up = np.array([[0.0, R, 0.0]]), np.array([[0.0, -1.0, 0.0]])
        source, eye = rng.uniform([-0.1, -0.1, -0.1], [0.1, 0.1, 0.1], (2, 3))
        one, other = (finish.returned(point, up, *pair, nominal_radius=R) for pair in ((source, eye), (eye, source)))
        assert one == pytest.approx(other, rel=1e-9)
        height = (np.arange(5000) + 0.5) / 5000  # light falls upright; the hemisphere in rings of equal solid angle
        eyes = np.column_stack([np.sqrt(1 - height**2), R - height, np.zeros(5000)])
        points, normal = np.repeat(point, 5000, axis=0), np.repeat(up, 5000, axis=0)
        lobe = finish.returned(points, normal, np.zeros(3), eyes, nominal_radius=R)
        assert 2 * np.mean(lobe * height) == pytest.approx(1, abs=0.01)  # Lambert's 1 is 1 by this too


def test_a_stain_is_as_dark_as_stated_in_its_middle_and_leaves_the_wall_beside_it():
    patch, band = Patch(1.0, 0.1, 0.03, 0.05, edge=0.01), Band((0.2, 0.22), 0.3, edge=0.002)
    finish = Finish(reflectance=0.9, stains=(patch, band))
    assert finish.matt(np.array([0.1, 0.21, 0.14, 0.1]), np.array([1.0, 4.0, 1.0, 1.3]), R) == pytest.approx(
        [0.05, 0.3, 0.9, 0.9]
    )
    edge = finish.matt(np.linspace(0.12, 0.13, 50), np.ones(50), R)
    assert (np.diff(edge) > 0).all()  # soft: from 0.05 at its inner to 0.9 at its outer end
    assert edge[[0, -1]] == pytest.approx([0.05, 0.9])


@pytest.mark.parametrize(("spacing", "radius"), [(0.02, 0.006), (0.011, 0.003)])
def test_specks_cover_as_much_of_the_wall_as_their_sizes_say(spacing, radius):
    specks = Specks(spacing, radius, seed=4)
    cover = specks.cover(AXIAL, CLOCK, R)
    size = radius * (0.3 + 0.7 * np.linspace(0, 1, 1000))
    core = np.pi * np.mean((0.85 * size) ** 2)  # the middle of the edge of 0.3 radii: half covered
    around = 2 * np.pi * R / int(2 * np.pi * R / spacing)
    assert cover.mean() == pytest.approx(core / (spacing * around), rel=0.1)
    assert np.array_equal(cover, Specks(spacing, radius, seed=4).cover(AXIAL, CLOCK, R))
    assert not np.array_equal(cover, Specks(spacing, radius, seed=5).cover(AXIAL, CLOCK, R))


def test_a_deposit_stands_up_from_the_wall_and_is_the_truth_there():
    patch = Patch(2.0, 0.0, 0.04, 0.5, height=0.004)
    wall = PipeWall(R, (Deposit(patch),), Finish(stains=(patch,)))
    pose = Pose.identity() @ Pose.from_roll_pitch_yaw(translation=(0.0, 0.0, -0.33))
    lit = seen(wall, pose=pose)
    truth = true_ring(lit, RIG, wall, pipe_from_rig=pose, line=LINE)
    on, off = np.abs(truth.clock - 2.0) < 0.2, np.abs(truth.clock - 2.0) > 0.3
    assert truth.radius[on] == pytest.approx(R - 0.004, abs=1e-9)
    assert truth.radius[off] == pytest.approx(R, abs=1e-9)
    assert np.median(truth.signal[on]) == pytest.approx(0.5 * np.median(truth.signal[off]), rel=0.1)  # it stands nearer


def test_nothing_under_water_is_seen_and_everything_above_it_is():
    wall = replace(WALL, water=Water(0.04))
    lit = seen(wall)
    truth, dry = (true_ring(seen(one), RIG, one, pipe_from_rig=POSE, line=LINE) for one in (wall, WALL))
    rig_points = np.column_stack([truth.radius * np.sin(truth.clock), -truth.radius * np.cos(truth.clock), truth.axial])
    under = POSE.apply(rig_points)[:, 1] > R - 0.04
    assert 0.15 < under.mean() < 0.35
    assert np.array_equal(truth.visible, dry.visible & ~under)
    assert not truth.signal[under].any()
    assert truth.radius == pytest.approx(dry.radius, abs=1e-12)  # the wall itself is where it was
    assert not lit.energy[POSE.apply(lit.points)[:, 1] > R - 0.04].any()


def test_a_camera_ray_reflected_by_the_water_meets_the_wall_that_it_shows():
    water = Water(0.05, ripple=0.0)
    wall = replace(WALL, water=water)
    lit = seen(wall)
    (stray,) = lit.stray
    shown = np.flatnonzero(stray.energy > 0)
    assert shown.size > 50
    way = RIG.camera.unproject(stray.u[shown], stray.v[shown]).direction @ POSE.rotation.T
    eye = POSE.translation
    at = eye + ((R - 0.05 - eye[1]) / way[:, 1])[:, None] * way
    back = way * [1.0, -1.0, 1.0]
    towards = POSE.apply(lit.points[shown]) - at
    assert np.linalg.norm(np.cross(back, towards), axis=1) / np.linalg.norm(back, axis=1) == pytest.approx(0, abs=1e-6)
    assert (wall.depth(at) < 0).all()
    assert (stray.energy < lit.energy[np.newaxis, shown].max()).all()
    whole = line_image(seen(), SHAPE, psf_sigma=0.9).sum()
    assert lit.energy.sum() + stray.energy.sum() < whole  # a mirror shows less than what it hides


def test_waves_spread_the_mirror_image_without_adding_light():
    still, waved = (seen(replace(WALL, water=Water(0.05, ripple=slope))).stray[0] for slope in (0.0, 0.03))
    assert waved.energy == pytest.approx(still.energy)
    lit = still.energy > 0
    assert np.median(np.linalg.norm(waved.spread[lit], axis=1)) > 2 * np.median(
        np.linalg.norm(still.spread[lit], axis=1)
    )


def test_glints_lie_on_the_water_surface_in_the_light():
    wall = replace(WALL, water=Water(0.05, glints=40.0))
    glints = seen(wall).stray[1]
    lit = glints.energy > 0
    assert 20 < lit.sum() < 70  # Poisson about 40
    rays = RIG.camera.unproject(glints.u[lit], glints.v[lit]).direction
    points = POSE.apply(rays * (0.33 / rays[:, 2])[:, None])  # the laser plane
    assert points[:, 1] == pytest.approx(R - 0.05, abs=1e-6)


@pytest.mark.parametrize("kind", sorted({*RIG_KINDS} - {"spot-array"}))  # spots draw no line
def test_every_rig_sees_stains_and_water_and_travels_to_other_machines(kind):
    rng = np.random.default_rng(5)
    for _ in range(3):
        rig, stain = random_rig(rng, R, kind=kind), Patch(3.0, 0.0, 0.02, 0.1)
        wall = PipeWall(R, finish=Finish(contrast=0.2, specular=0.2, stains=(stain,)), water=Water(0.02, glints=5.0))
        wall = pickle.loads(pickle.dumps(wall))
        for laser in range(len(rig.lasers)):
            line = {"line": LINE, "psf_sigma": 0.9, "laser": laser}
            pose = head_pose(np.pi) if isinstance(rig.mount, SideFacing) else Pose.identity()
            lit = lit_line(rig, wall, pipe_from_rig=pose, **line)
            passed = seen_through(lit, rig, wall, pipe_from_rig=pose, laser=laser)
            assert not lit.energy[pose.apply(lit.points)[:, 1] > R - 0.02].any()
            image = line_image(passed, (rig.camera.height, rig.camera.width), psf_sigma=0.9)
            for stray in passed.stray:
                image += line_image(stray, image.shape, psf_sigma=0.9)
            assert np.isfinite(image).all()


def test_a_camera_or_laser_under_water_is_told():
    low = Pose.from_roll_pitch_yaw(translation=(0.0, 0.12, -0.33))
    with pytest.raises(InputError, match=r"camera stands 0\.02 m under water; lower the level"):
        seen(replace(WALL, water=Water(0.05)), pose=low)
    pitched = Pose.from_roll_pitch_yaw(0.0, -0.2, translation=(0.0, 0.06, -0.33))
    with pytest.raises(InputError, match=r"laser stands .* under water"):
        seen(replace(WALL, water=Water(0.05)), pose=pitched)


def test_a_smudge_dims_what_is_seen_through_it_and_moves_nothing():
    plain = seen()
    worst = int(np.argmax(plain.signal))
    smudge = Smudge(float(plain.u[worst]), float(plain.v[worst]), 30.0, transmission=0.2)
    dim = seen(window=Window(smudges=(smudge,)))
    away = np.hypot(plain.u - smudge.u, plain.v - smudge.v) > 30
    assert dim.signal[worst] == pytest.approx(0.2 * plain.signal[worst])
    assert np.array_equal(dim.signal[away], plain.signal[away])
    assert (dim.signal <= plain.signal).all()
    truth = true_ring(dim, RIG, WALL, pipe_from_rig=POSE, line=LINE)
    assert truth.signal.min() < 0.4 * truth.signal.max()


def test_a_ghost_is_the_line_again_weaker_and_about_the_principal_point():
    lit = seen(window=Window(ghosts=(Ghost(0.2, 0.9, (3.0, -1.0)),)))
    (ghost,) = lit.stray
    assert ghost.u == pytest.approx(158.0 + 3 + 0.9 * (lit.u - 158.0))
    assert ghost.v == pytest.approx(121.0 - 1 + 0.9 * (lit.v - 121.0))
    assert ghost.energy.sum() == pytest.approx(0.2 * lit.energy.sum())
    assert np.array_equal(lit.signal, seen().signal)


def test_a_halo_loses_no_light_and_carries_its_share_away_from_the_line():
    light = line_image(seen(), SHAPE, psf_sigma=0.9)
    scattered = Window(halo=0.2, halo_sigma=6.0).scattered(light)
    assert scattered.sum() == pytest.approx(light.sum(), rel=0.01)
    point, place = np.zeros((101, 101), np.float32), np.arange(-50, 51)
    point[50, 50] = 1.0
    around = Window(halo=0.2, halo_sigma=6.0).scattered(point)
    assert around[50, 50] == pytest.approx(0.8, abs=0.01)
    assert (around.sum(axis=0) * place**2).sum() == pytest.approx(0.2 * 6.0**2, rel=0.02)


def test_a_lamp_is_a_white_crescent_inside_the_ring_and_no_part_of_the_truth():
    shine = Lamp(1.0, clock=0.3, width=1.0, brightness=0.5).shine(RIG, R, psf_sigma=0.9)
    centre = np.hypot(shine.u - 158.0, shine.v - 121.0)
    lit = seen()
    assert centre[shine.energy > 0].max() < np.hypot(lit.u - 158.0, lit.v - 121.0).min()
    light = line_image(shine, SHAPE, psf_sigma=0.9)
    assert light.max() == pytest.approx(0.5, rel=0.1)
    image = photograph_all({0: lit}, RIG, line=LINE, sensor=SENSOR, rng=np.random.default_rng(1), lamps=[shine])
    brightest = np.unravel_index(np.argmax(light), light.shape)
    assert np.ptp(image[brightest].astype(int)) < 25  # white, up to noise


def test_an_overlay_is_written_where_stated_and_fills_in_the_station():
    images = [np.full((60, 300, 3), 7, np.uint8) for _ in range(3)]
    overlay = Overlay("MH 12  {station:03d}  {axial:.2f} m", u=30, v=20, height=20)
    for image, station in zip(images, (7, 8, 7), strict=True):
        overlay.write_on(image, station=station, axial=0.1 * station)
    assert images[0].max() == 255
    assert (images[0][:18] == 7).all()
    assert (images[0][:, :28] == 7).all()
    assert not np.array_equal(images[0], images[1])
    assert np.array_equal(images[0], images[2])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: Finish(reflectance=-0.1), "reflectance of a wall must be between 0"),
        (lambda: Finish(specular=1.5), "specular share between 0 and 1"),
        (lambda: Finish(contrast=2.0), "contrast between 0 and 1"),
        (lambda: Patch(0.0, 0.0, -0.1), "radius of a patch must be positive"),
        (lambda: Band((0.2, 0.1)), "length of a band must be positive"),
        (lambda: Specks(0.01, 0.01), "need a spacing of at least twice"),
        (lambda: Water(0.0), "must stand above the invert"),
        (lambda: Smudge(0, 0, 10, transmission=2.0), "lets through 0 to 1"),
        (lambda: Ghost(0.1, 0.0), "scale between"),
        (lambda: Window(halo=1.0), "scatters 0 to 1"),
        (lambda: Lamp(-1.0), "distance of a lamp must be positive"),
        (lambda: Overlay("{depth}"), "may hold {station} and {axial} only"),
    ],
)
def test_an_effect_that_cannot_be_is_refused_in_a_sentence(wrong, said):
    with pytest.raises(InputError, match=said):
        wrong()

"""What the simulation calls true agrees with laser rays followed step by step."""

import numpy as np
import pytest

from calibore import metrics
from calibore.geometry import Pose, clock_of
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, triangulate
from calibore.simulation import (
    LineLight,
    Ovality,
    PipeWall,
    Rail,
    lit_line,
    random_pose,
    random_rig,
    random_wall,
    true_quantities,
    true_ring,
)

R0 = 0.15
LINE = LineLight()
RIG = Rig(
    "perpendicular-plane",
    Camera(512, 384, Lens("sine-law", 285.0, 192.0), (256.0, 192.0)),
    (Laser(Plane(0.33), "red"),),
)


def seen(rig, wall, pose, line=LINE):
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=0.9)
    return lit, true_ring(lit, rig, wall, pipe_from_rig=pose, line=line)


def first_wall(rig, wall, pose, clock, steps=900):
    """Radius [m] at which laser rays at rig `clock` leave the open, by small steps and then halving them."""
    surface = rig.lasers[0].surface
    ray = np.stack([np.sin(clock), -np.cos(clock), surface.tilt_x * np.sin(clock) - surface.tilt_y * np.cos(clock)], -1)

    def depth(radius):
        return wall.depth(pose.apply(radius[..., None] * ray + np.array([0.0, 0.0, surface.baseline])))

    radii = np.linspace(0.5, 1.4, steps) * wall.nominal_radius
    inside = np.stack([depth(np.full(clock.shape, radius)) > 0 for radius in radii])
    low, high = radii[inside.argmax(axis=0) - 1], radii[inside.argmax(axis=0)]
    for _ in range(50):
        middle = (low + high) / 2
        low, high = np.where(depth(middle) > 0, low, middle), np.where(depth(middle) > 0, middle, high)
    return low


def random_scenes(seed, count):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        wall = random_wall(rng)
        rig = random_rig(rng, wall.nominal_radius)
        yield rig, wall, random_pose(rng, rig, wall.nominal_radius)


def test_the_true_ring_is_the_first_wall_that_each_laser_ray_meets():
    for rig, wall, pose in random_scenes(1, 5):
        _, ring = seen(rig, wall, pose)
        radius = first_wall(rig, wall, pose, ring.clock)
        error = np.abs(ring.radius - radius)
        # Rays that graze the flank of a rail may end on either side of it: at most two per flank.
        assert np.sum(error > 1e-9) <= 4
        assert np.median(error) < 1e-13


def test_the_line_lies_on_wall_and_laser_plane():
    for rig, wall, pose in random_scenes(2, 5):
        lit, _ = seen(rig, wall, pose)
        assert np.abs(rig.lasers[0].surface.value(lit.points)).max() < 1e-12
        assert np.abs(wall.depth(pose.apply(lit.points))).max() < 1e-12


def test_triangulating_the_true_line_gives_the_true_radius():
    for rig, wall, pose in random_scenes(3, 5):
        lit, _ = seen(rig, wall, pose)
        found = triangulate(rig, lit.u, lit.v)
        assert found.radius == pytest.approx(lit.radius, abs=1e-12)
        assert found.axial == pytest.approx(lit.points[:, 2], abs=1e-12)


def test_what_is_visible_has_a_free_sight_line_and_what_is_hidden_has_none():
    rail = PipeWall(R0, (Rail(0.02, 0.03, axial=(-1.0, 0.0)), Ovality((2.0, 2.0))))
    pose = Pose.from_roll_pitch_yaw(0.02, translation=(0.004, -0.002, 0.012 - 0.33))
    lit, _ = seen(RIG, rail, pose)
    points, fraction = pose.apply(lit.points), (np.linspace(0.01, 1, 900) ** 2)[:, None, None]
    hidden = (rail.depth(points + fraction * (pose.translation - points)) > 1e-9).any(axis=0)
    assert 0.02 < hidden.mean() < 0.2
    assert np.mean(hidden != ~lit.visible) < 0.002  # the very edges of the shadow


def test_the_end_of_a_rail_hides_the_invert_behind_it_and_nothing_else():
    wall = PipeWall(R0, (Rail(0.02, 0.03, axial=(-1.0, 0.0)),))
    shadow = 0.02 * 0.33 / R0  # how far behind its end the rail hides the wall
    for behind, hidden in ((0.5 * shadow, True), (1.5 * shadow, False)):
        _, ring = seen(RIG, wall, Pose(np.eye(3), np.array([0.0, 0.0, behind - 0.33])))
        at_rail = np.abs(ring.clock - np.pi) < np.arcsin(0.012 / R0)
        assert ring.visible[at_rail].any() != hidden
        assert ring.visible[np.abs(ring.clock - np.pi) > np.arcsin(0.016 / (R0 - 0.02))].all()
        assert ring.radius == pytest.approx(np.full(400, R0), abs=1e-12)
        assert np.all((ring.signal > 0) == ring.visible)


def test_a_rail_shadows_the_wall_from_an_off_centre_laser():
    wall = PipeWall(R0, (Rail(0.03, 0.02, edge=0.0005),))
    _, ring = seen(RIG, wall, Pose(np.eye(3), np.array([0.05, 0.0, -0.33])))
    brute = first_wall(RIG, wall, Pose(np.eye(3), np.array([0.05, 0.0, -0.33])), ring.clock)
    assert np.sum(np.abs(ring.radius - brute) > 1e-9) <= 2
    lit, _ = seen(RIG, wall, Pose(np.eye(3), np.array([0.05, 0.0, -0.33])))
    # the laser stands on the right, at 3 o'clock: the wall to the left of the rail gets no light
    pipe = np.sort(clock_of(lit.points[:, 0] + 0.05, lit.points[:, 1]))
    dark = np.argmax(np.diff(pipe))
    assert 0.05 < pipe[dark + 1] - pipe[dark] < 0.3
    assert pipe[dark] == pytest.approx(np.pi + 0.01 / R0, abs=0.03)


def test_a_strut_cuts_the_ring_where_it_stands():
    line = LineLight(shadows=((1.0, 0.3), (6.2, 0.4)))
    lit, ring = seen(RIG, PipeWall(R0), Pose(np.eye(3), np.array([0.01, 0.0, 0.0])), line)
    for clock, visible in ((ring.clock, ring.visible), (lit.clock, lit.visible)):
        expected = (np.abs(clock - 1.0) <= 0.15) | (np.abs(np.mod(clock - 6.2 + 3, 2 * np.pi) - 3) <= 0.2)
        assert np.array_equal(~visible, expected)


def test_what_leaves_the_image_is_not_visible():
    near = Rig(
        "perpendicular-plane", Camera(512, 384, Lens("equidistant", 400.0, 192.0), (256.0, 192.0)), (Laser(Plane(0.3)),)
    )
    lit, ring = seen(near, PipeWall(0.165), Pose.identity())  # image radius 400 atan(0.55) = 201 px, half height 192
    assert np.array_equal(lit.visible, np.abs(lit.v - 191.5) < 192)
    assert 0.5 < ring.visible.mean() < 0.9


def test_true_quantities_of_an_ellipse_like_wall_are_its_formula():
    wall, pose = PipeWall(R0, (Ovality((3.0, 3.0), axis=0.0),)), Pose(np.eye(3), np.array([0.006, -0.004, -0.33]))
    lit, _ = seen(RIG, wall, pose)
    found = true_quantities(lit, nominal_radius=R0)
    assert (found["centre_x"], found["centre_y"]) == pytest.approx((-0.006, 0.004), abs=4e-5)  # 3 % oval
    assert found["diameter_mean"] == pytest.approx(2 * R0, rel=1e-5)
    assert found["diameter_vertical"] == pytest.approx(2 * R0 * 1.03, rel=1e-5)
    assert found["diameter_horizontal"] == pytest.approx(2 * R0 * 0.97, rel=1e-5)
    assert found["ovality_harmonic"] == pytest.approx(3.0, abs=1e-3)
    assert found["ovality_range"] == pytest.approx(6.0, abs=2e-3)
    assert found["deflection"] == pytest.approx(3.0, abs=1e-3)
    assert found["area"] == pytest.approx(np.pi * R0**2 * (1 + 0.03**2 / 2), rel=1e-5)
    assert found["diameter_equivalent_area"] == pytest.approx(
        float(metrics.diameter_equivalent_area(found["area"])), rel=1e-12
    )


def test_the_ring_is_regular_in_rig_clock():
    for rig, wall, pose in random_scenes(4, 3):
        lit, ring = seen(rig, wall, pose)
        assert ring.clock == pytest.approx(np.radians(0.9) * np.arange(400))
        away = np.abs(np.mod(lit.clock[:, None] - ring.clock + np.pi, 2 * np.pi) - np.pi).argmin(axis=0)
        close = np.abs(lit.radius[away] - ring.radius) < 0.02 * wall.nominal_radius
        assert close.mean() > 0.98  # flanks of rails apart
        assert clock_of(lit.points[:, 0], lit.points[:, 1]) == pytest.approx(lit.clock)

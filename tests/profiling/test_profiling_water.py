"""What water shows of a pipe is told from its wall, and walls are not taken for water."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import Job, measure_image
from calibore.profiling._line_ring import line_on_wall
from calibore.profiling._search import find_line
from calibore.rigs import Laser, Rig
from calibore.simulation import (
    Dent,
    LateralOpening,
    LineLight,
    Ovality,
    PipeWall,
    Rail,
    Sensor,
    Water,
    random_pose,
    random_rig,
    render_ring,
)
from calibore.status import Status

R = 0.15
RIG = Rig(
    "perpendicular-plane",
    Camera(512, 384, Lens("sine-law", 285.0, 192.0), (256.0, 192.0)),
    (Laser(Plane(0.33), "red"),),
)
LINE, SENSOR = LineLight(sigma=0.0008), Sensor(speckle_contrast=0.3)


def ring_of(wall, *, rig=RIG, roll=0.0, seed=0, ahead=0.33):
    pose = Pose.from_roll_pitch_yaw(roll, translation=(0.002, 0.001, -ahead))
    image = render_ring(rig, wall, pipe_from_rig=pose, rng=np.random.default_rng(seed), line=LINE, sensor=SENSOR)
    return measure_image(image, Job.of(rig, R))


def same_water(image, rig):
    """How many rays show water, which both kernels must tell of the same ones."""
    job = Job.of(rig, R)
    stripe = find_line(image, rig, job.looks[0].search, channel="red", estimator=job.estimator)
    ours, theirs = (line_on_wall(stripe, job.rig, prior_radius=R, kernel=kernel) for kernel in ("native", "numpy"))
    np.testing.assert_array_equal(ours.rays.status, theirs.rays.status)
    np.testing.assert_allclose(ours.ring.radius, theirs.ring.radius, rtol=0, atol=1e-11 * R)
    return int(np.count_nonzero(ours.rays.status == Status.WATER))


def half_angle(share):
    """Half of the arc [rad] that water covers which stands at `share` of the pipe's height."""
    return np.arccos(1 - 2 * share)


@pytest.mark.parametrize("share", [0.18, 0.22, 0.27, 0.32, 0.37, 0.42])
@pytest.mark.parametrize("roll", [0.0, 0.2])
def test_the_wall_upside_down_in_water_is_no_wall(share: float, roll: float) -> None:
    wall = PipeWall(R, (Ovality((1.5, 1.5), axial=(-1.0, 1.0)),), water=Water(2 * R * share, ripple=0.002))
    ring = ring_of(wall, roll=roll, seed=int(1000 * share))
    from_invert = np.abs(np.mod(ring.clock - (np.pi - roll) + np.pi, 2 * np.pi) - np.pi)
    found, covered = np.isfinite(ring.radius), from_invert < half_angle(share) - np.radians(3)
    told_right = np.abs(ring.radius - R) < 0.04 * R  # where wall and image part: oval and off-centre by 3 % of R
    assert not (found & ~told_right)[covered].any()
    assert found[covered].mean() < 0.05
    assert found[from_invert > half_angle(share) + np.radians(3)].mean() > 0.98
    if share > 0.25:  # below, the picture hardly reaches down to the image
        assert np.any(ring.status[covered] == Status.WATER)


@pytest.mark.parametrize("kind", ["single-cone", "coaxial-cone", "reversed-cone"])
def test_so_it_is_for_cones_of_light_whose_mirror_image_lies_elsewhere(kind: str) -> None:
    rng = np.random.default_rng(5)
    found, false = [], []
    for seed in range(3):
        rig = random_rig(rng, R, kind=kind)
        pose = random_pose(rng, rig, R)
        wall = PipeWall(R, water=Water(0.6 * R, ripple=0.002))
        image = render_ring(rig, wall, pipe_from_rig=pose, rng=np.random.default_rng(seed), line=LINE, sensor=SENSOR)
        ring = measure_image(image, Job.of(rig, R))
        from_invert = np.abs(np.mod(ring.clock, 2 * np.pi) - np.pi)
        false.append(np.isfinite(ring.radius)[from_invert < half_angle(0.3) - np.radians(25)])  # rolled by up to 17 deg
        found.append(np.isfinite(ring.radius)[from_invert > half_angle(0.3) + np.radians(25)])
    assert np.mean(false) < 0.02
    assert np.mean(found) > 0.9


def test_glints_on_the_water_are_no_wall() -> None:
    false, covered = 0, 0
    for seed in range(6):
        ring = ring_of(PipeWall(R, water=Water(0.2 * R, glints=4.0, seed=seed)), seed=seed)
        under = np.abs(ring.clock - np.pi) < half_angle(0.1) - np.radians(4)
        false, covered = false + int(np.isfinite(ring.radius[under]).sum()), covered + int(under.sum())
    assert false < 0.02 * covered


DRY = {
    "oval": (Ovality((5.0, 5.0), axial=(-1.0, 1.0)),),
    "lying oval": (Ovality((5.0, 5.0), axial=(-1.0, 1.0), axis=np.pi / 2),),
    "dented": (Dent(0.015, np.pi, 0.0, 0.5, 0.1),),
    "bulged": (Dent(-0.015, np.pi, 0.0, 0.5, 0.1),),
    "railed": (Rail(0.015, 0.05, edge=0.001),),
    "wide rail": (Rail(0.012, 0.12, edge=0.001),),
    "opened": (LateralOpening(0.05, 0.02, np.pi, 0.0, edge=0.01),),
}


@pytest.mark.parametrize("name", DRY)
def test_a_dry_pipe_of_any_shape_is_not_under_water(name: str) -> None:
    for seed in range(3):
        ring = ring_of(PipeWall(R, DRY[name]), seed=seed)
        assert not np.any(ring.status == Status.WATER)
        assert np.isfinite(ring.radius).mean() > 0.9  # of an opening's inside little is seen


def test_a_strut_shadow_over_the_invert_is_no_water() -> None:
    line = replace(LINE, shadows=((np.pi, 0.7),))
    pose = Pose.from_roll_pitch_yaw(0.0, translation=(0.0, 0.0, -0.33))
    image = render_ring(RIG, PipeWall(R), pipe_from_rig=pose, rng=np.random.default_rng(1), line=line, sensor=SENSOR)
    ring = measure_image(image, Job.of(RIG, R))
    assert not np.any(ring.status == Status.WATER)


@pytest.mark.parametrize("name", DRY)
def test_both_kernels_call_a_dry_pipe_dry(name: str) -> None:
    pose = Pose.from_roll_pitch_yaw(0.1, translation=(0.002, 0.001, -0.33))
    rng = np.random.default_rng(len(name))
    assert same_water(render_ring(RIG, PipeWall(R, DRY[name]), pipe_from_rig=pose, rng=rng, line=LINE), RIG) == 0


@pytest.mark.parametrize("law", ["perspective", "stereographic", "equidistant", "sine-law", "equisolid-angle"])
def test_both_kernels_tell_the_same_rays_of_water(law: str) -> None:
    wet = []
    for seed, c1 in enumerate((0.0, 0.02, 0.0, -0.02, 0.0, 0.0)):
        rng = np.random.default_rng(seed)
        rig = replace(RIG, camera=replace(RIG.camera, lens=Lens(law, 270.0, 192.0, c1=c1), aspect=1.01))
        level = 2 * R * (0.18 + 0.05 * seed)
        water = Water(level, ripple=0.002) if seed < 4 else Water(0.2 * R, glints=4.0, seed=seed)
        pose = Pose.from_roll_pitch_yaw(rng.normal(0, 0.1), translation=(0.003, -0.002, -0.33))
        image = render_ring(rig, PipeWall(R, water=water), pipe_from_rig=pose, rng=rng, line=LINE, sensor=SENSOR)
        wet.append(same_water(image, rig))
    assert np.count_nonzero(wet) >= 2


@pytest.mark.parametrize("kind", ["single-cone", "coaxial-cone", "reversed-cone"])
def test_both_kernels_tell_the_same_rays_of_a_cone(kind: str) -> None:
    rng, wall = np.random.default_rng(5), PipeWall(R, water=Water(0.6 * R, ripple=0.002))
    rig = random_rig(rng, R, kind=kind)
    pose = random_pose(rng, rig, R)
    assert same_water(render_ring(rig, wall, pipe_from_rig=pose, rng=rng, line=LINE, sensor=SENSOR), rig) > 0

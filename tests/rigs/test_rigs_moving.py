"""A rig with other values of its parameters is the rig those values describe."""

from dataclasses import replace

import numpy as np
import pytest
from random_engine_rigs import KINDS, random_pixels, random_rig

from calibore.errors import InputError
from calibore.lasers import Cone
from calibore.optics import Camera, FlatPort, Lens
from calibore.rigs import Laser, Rig, moved, triangulate


@pytest.mark.parametrize("kind", KINDS)
def test_a_small_move_changes_points_as_the_sensitivities_say(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    rig, laser, size = random_rig(rng, kind)
    u, v = random_pixels(rng, 60)
    before = triangulate(rig, u, v, laser=laser, prior_radius=size)
    for i, name in enumerate(rig.parameter_names):
        step = 1e-6 * (100.0 if name.startswith("camera.") else 1.0)
        after, less = (
            triangulate(moved(rig, {name: sign * step}), u, v, laser=laser, branch=before.branch).points
            for sign in (1, -1)
        )
        slope = (after - less) / (2 * step)
        ours = before.d_parameters[:, :, i]
        near = (before.status == 0) & (np.linalg.norm(before.d_pixel, axis=(1, 2)) < size)  # away from frontiers
        near &= np.isfinite(slope).all(axis=1)
        scale = np.abs(ours[near]).max(initial=1e-9)
        assert np.abs(slope[near] - ours[near]).max(initial=0.0) < 2e-3 * scale, name


def test_moving_there_and_back_gives_the_same_rig():
    rng = np.random.default_rng(1)
    rig, *_ = random_rig(rng, "dual")
    changes = dict(zip(rig.parameter_names, rng.uniform(0, 1e-3, len(rig.parameter_names)), strict=True))
    back = moved(moved(rig, changes), {name: -change for name, change in changes.items()})
    for ours, theirs in zip(back.lasers, rig.lasers, strict=True):
        values = [[getattr(one.surface, name) for name in one.surface.parameter_names] for one in (ours, theirs)]
        assert np.allclose(*values, rtol=0, atol=1e-15)
    assert np.allclose(back.camera.principal_point, rig.camera.principal_point)


def test_a_coaxial_cone_may_move_to_either_side_of_the_axis():
    camera = Camera(640, 480, Lens("equidistant", 200.0, 240.0), (319.5, 239.5))
    rig = Rig("coaxial-cone", camera, (Laser(Cone(0.0, 0.0, 0.8, 0.0, 0.2)),))
    u, v = np.array([400.0, 319.5]), np.array([239.5, 300.0])
    up, down = (
        triangulate(moved(rig, {"laser.baseline": s * 0.01, "laser.aim": s * 0.02}), u, v, prior_radius=0.2)
        for s in (1, -1)
    )
    mirrored = triangulate(moved(rig, {"laser.baseline": 0.01, "laser.aim": 0.02}), u, 479 - v, prior_radius=0.2)
    assert np.allclose(down.radius, mirrored.radius, rtol=1e-12)
    assert not np.allclose(down.radius, up.radius, rtol=1e-3)


def test_all_parts_of_a_camera_move():
    lens = Lens("polynomial", 200.0, 240.0, 0.01, polynomial=(-0.02, 0.001))
    port = FlatPort(0.005, 1.5, 0.01, 1.33)
    camera = Camera(640, 480, lens, (319.5, 239.5), 1.1, (0.001, 0.0002), port)
    rig = Rig("coaxial-cone", camera, (Laser(Cone(0.0, 0.0, 0.8, 0.0, 0.2)),))
    changes = {name: 1e-4 * (1 + i) for i, name in enumerate(camera.parameter_names)}
    other = moved(rig, changes).camera
    assert other.lens == replace(
        lens,
        k=200.0 + changes["camera.k"],
        c1=0.01 + changes["camera.c1"],
        c2=changes["camera.c2"],
        polynomial=(-0.02 + changes["camera.polynomial_3"], 0.001 + changes["camera.polynomial_5"]),
    )
    assert other.pupil_walk == (0.001 + changes["camera.pupil_walk_2"], 0.0002 + changes["camera.pupil_walk_4"])
    assert other.port is not None
    assert other.port.index == 1.5 + changes["camera.port_index"]
    assert other.aspect == 1.1 + changes["camera.aspect"]


def test_a_parameter_that_is_not_there_is_refused():
    rig, *_ = random_rig(np.random.default_rng(2), "plane")
    with pytest.raises(InputError, match=r"no parameter laser\.clock"):
        moved(rig, {"laser.clock": 0.1})

"""Angles and shadows, against closed forms and against marching along rays."""

import numpy as np
import pytest
from random_designs import CONFIGURATIONS, random_study

from calibore.design import (
    Study,
    misalignments,
    occlusion,
    plane_rig,
    ring_clocks,
    shadows,
    side_rig,
    source_of,
)
from calibore.errors import InputError
from calibore.rigs import lit_points, moved


@pytest.mark.parametrize("baseline", [0.5, 1.0, 2.0, 5.0])
def test_the_occlusion_angle_of_a_plane_is_that_of_the_source(baseline):
    """Swanbom 2007, eq. 4-25."""
    (found,) = occlusion(plane_rig(baseline), nominal_radius=1.0)
    np.testing.assert_allclose(found.camera, np.arctan(1 / baseline), rtol=1e-12)
    np.testing.assert_allclose(found.light, np.pi / 2, rtol=1e-7)


def test_a_plane_throws_a_shadow_as_long_as_the_bump_is_high_times_the_baseline():
    found = shadows(plane_rig(2.0), nominal_radius=1.0, heights=[0.0, 0.05, 0.1])
    np.testing.assert_allclose(found.along, [0.0, 0.1, 0.2], rtol=1e-12)
    np.testing.assert_allclose(found.around, 0.0)


def test_a_side_facing_head_sees_under_the_angle_from_its_baseline():
    (found,) = occlusion(side_rig(0.4), nominal_radius=1.0)
    np.testing.assert_allclose(found.camera, np.arctan(1 / 0.4), rtol=1e-12)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_shadow_is_as_long_as_marching_along_the_rays_finds(configuration):
    """A ridge hides a point when the ray to the pupil or to the light passes the ridge's place below its top."""
    rng = np.random.default_rng([8, CONFIGURATIONS.index(configuration)])
    study = random_study(rng, configuration, nominal_radius=1.0)
    rig, height = study.rig(), float(rng.uniform(0.01, 0.1))
    found = shadows(rig, nominal_radius=1.0, heights=height)
    longest = np.zeros(2)
    march = np.linspace(0, 1, 200_001)[1:, None]
    for number, laser in enumerate(rig.lasers):
        clock = ring_clocks(rig, 12)
        clock = clock[number : number + 1] if configuration == "spot-array" else clock
        for point in lit_points(rig, clock, 1.0, laser=number):
            reach = np.zeros((2, 2))
            for view in (rig.mount.translation, source_of(laser.surface)):
                ray = point + march * (view - point)
                low = np.hypot(ray[:, 0], ray[:, 1]) > 1.0 - height
                end = ray[: np.argmin(low)] if not low.all() else ray
                along = end[:, 2] - point[2]
                around = np.arctan2(point[0] * end[:, 1] - point[1] * end[:, 0], end[:, :2] @ point[:2])
                for axis, shift in enumerate((along, around)):
                    reach[axis] = min(reach[axis, 0], shift.min(initial=0)), max(reach[axis, 1], shift.max(initial=0))
            longest = np.maximum(longest, reach[:, 1] - reach[:, 0])
    everywhere = 1.02 if configuration.endswith("cone") else 1.0
    assert longest[0] <= found.along[0] + 1e-3
    assert longest[1] <= found.around[0] + 1e-3
    assert found.along[0] <= everywhere * longest[0] + 1e-3
    assert found.around[0] <= everywhere * longest[1] + 1e-3


def test_a_bump_as_high_as_the_pipe_is_refused():
    with pytest.raises(InputError, match="lower than the pipe's radius"):
        shadows(plane_rig(2.0), nominal_radius=1.0, heights=1.2)


def test_a_tilted_plane_errs_as_its_closed_form_says():
    """Light at z = D - t R is read as if at D: R D / (D - t R), so R^2 t / D at first order (equations.md, 5.9)."""
    (found,) = misalignments(plane_rig(0.5), nominal_radius=1.0)
    np.testing.assert_allclose(found.worst_error, 1 / (1 - np.tan(found.angle) / 0.5) - 1, rtol=1e-9, atol=1e-12)
    assert (np.diff(found.u_radius) > 0).all()


def test_a_moved_rig_is_the_same_rig_but_for_what_moved():
    rig = Study("dual-cone", 0.15).rig()
    other = moved(rig, {"laser.1.aim": 0.01, "camera.k": 2.0, "camera.principal_point_u": -1.0})
    assert other.lasers[0] == rig.lasers[0]
    assert other.lasers[1].surface.aim == pytest.approx(rig.lasers[1].surface.aim + 0.01)
    assert other.camera.lens.k == pytest.approx(rig.camera.lens.k + 2)
    assert other.camera.principal_point == (511.0, 384.0)
    with pytest.raises(InputError, match=r"no parameter laser\.tilt"):
        moved(rig, {"laser.tilt": 1.0})

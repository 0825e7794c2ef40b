"""Laws that hold for every rig and every ray, wherever it is aimed."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as some

from calibore.lasers import GRAZING_SINE, Plane
from calibore.optics import LENS_NAMES, Camera, Lens
from calibore.rigs import Laser, Rig, triangulate
from calibore.status import Status

BATCH = 300


@some.composite
def rigs(draw):
    """Rigs with lenses from narrow to beyond a hemisphere, planes near and far, tilted up to 45 deg."""
    law = draw(some.sampled_from(LENS_NAMES))
    polynomial = tuple(draw(some.tuples(*[some.floats(-0.05, 0.05)] * 2))) if law == "polynomial" else ()
    lens = Lens(law, draw(some.floats(100, 2000)), 384.0, *draw(some.tuples(*[some.floats(-0.1, 0.1)] * 2)), polynomial)
    centre = draw(some.floats(400, 600)), draw(some.floats(300, 460))
    plane = Plane(draw(some.floats(0.01, 5)), draw(some.floats(-1, 1)), draw(some.floats(-1, 1)))
    return Rig("perpendicular-plane", Camera(1024, 768, lens, centre, draw(some.floats(0.8, 1.25))), (Laser(plane),))


def aimed_everywhere(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-200, 1224, BATCH), rng.uniform(-200, 968, BATCH)


seeds = some.integers(0, 2**32 - 1)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(rigs(), seeds)
def test_every_triangulated_point_lies_on_its_surface_on_its_ray_and_is_lit(rig, seed):
    u, v = aimed_everywhere(seed)
    result, surface = triangulate(rig, u, v), rig.lasers[0].surface
    measured = result.status == Status.OK
    points, rays = result.points[measured], rig.camera.unproject(u, v).direction[measured]
    size = np.linalg.norm(points, axis=1)
    assert (np.abs(surface.value(points)) <= 1e-9 * size).all()
    assert (np.abs(np.cross(points, rays)) <= 1e-9 * size[:, None]).all()
    assert (np.einsum("ni,ni->n", points, rays) > 0).all()
    normal = surface.gradient(points) / np.linalg.norm(surface.gradient(points), axis=1, keepdims=True)
    assert (np.abs(np.einsum("ni,ni->n", rays, normal)) >= GRAZING_SINE).all()


@settings(max_examples=150, deadline=None, derandomize=True)
@given(rigs(), seeds)
def test_a_point_has_a_value_exactly_when_its_status_says_so(rig, seed):
    u, v = aimed_everywhere(seed)
    u[::7] = np.nan
    result = triangulate(rig, u, v)
    measured = result.status == Status.OK
    for array in (result.points, result.d_pixel, result.d_parameters):
        assert np.isfinite(array[measured]).all()
        assert np.isnan(array[~measured]).all()
    assert (result.status[::7] == Status.NO_PEAK).all()
    lost = np.isnan(rig.camera.unproject(u, v).direction[:, 0]) & np.isfinite(u)
    assert np.array_equal(result.status == Status.OUTSIDE_LENS, lost)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(rigs(), seeds)
def test_a_measured_point_projects_back_to_its_pixel(rig, seed):
    u, v = aimed_everywhere(seed)
    result = triangulate(rig, u, v)
    measured = result.status == Status.OK
    again = rig.camera.project(result.points[measured])
    assert np.allclose(again, (u[measured], v[measured]), rtol=0, atol=1e-8)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(rigs(), seeds, some.floats(0.1, 10))
def test_a_rig_twice_as_large_measures_twice_as_large(rig, seed, scale):
    u, v = aimed_everywhere(seed)
    plane = rig.lasers[0].surface
    larger = Rig(rig.configuration, rig.camera, (Laser(Plane(scale * plane.baseline, plane.tilt_x, plane.tilt_y)),))
    ours, theirs = triangulate(rig, u, v), triangulate(larger, u, v)
    assert np.array_equal(ours.status, theirs.status)
    assert np.allclose(scale * ours.points, theirs.points, rtol=1e-12, atol=0, equal_nan=True)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(rigs(), seeds)
def test_the_mirrored_rig_measures_the_mirrored_pipe(rig, seed):
    u, v = aimed_everywhere(seed)
    plane, centre = rig.lasers[0].surface, rig.camera.principal_point[0]
    mirrored = Rig(rig.configuration, rig.camera, (Laser(Plane(plane.baseline, -plane.tilt_x, plane.tilt_y)),))
    ours, theirs = triangulate(rig, u, v), triangulate(mirrored, 2 * centre - u, v)
    near_grazing = ours.status != theirs.status  # mirrored pixels round differently
    assert near_grazing.mean() < 0.02
    good = (ours.status == Status.OK) & ~near_grazing
    size = np.linalg.norm(ours.points[good], axis=1, keepdims=True)
    assert (np.abs(ours.points[good] * (-1, 1, 1) - theirs.points[good]) < 1e-8 * size).all()


@settings(max_examples=60, deadline=None, derandomize=True)
@given(rigs(), seeds)
def test_a_small_move_of_the_pixel_moves_the_point_as_its_sensitivity_says(rig, seed):
    u, v = aimed_everywhere(seed)
    rng, step = np.random.default_rng(seed), 1e-4
    du, dv = rng.uniform(-step, step, (2, BATCH))
    here, before, after = (triangulate(rig, u + s * du, v + s * dv) for s in (0, -1, 1))
    steep = np.linalg.norm(here.d_pixel, axis=(1, 2)) > 0.05 * np.linalg.norm(here.points, axis=1)
    good = (here.status == Status.OK) & (before.status == Status.OK) & (after.status == Status.OK) & ~steep
    moved = (after.points - before.points)[good] / 2
    said = here.d_pixel[good, :, 0] * du[good, None] + here.d_pixel[good, :, 1] * dv[good, None]
    size = np.linalg.norm(here.points[good], axis=1, keepdims=True)
    assert (np.abs(moved - said) < 1e-10 * size + 1e-6 * np.abs(said).max(initial=0)).all()

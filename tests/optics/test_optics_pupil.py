"""The pupil that walks and the flat port: where camera rays really start, and how they leave the housing."""

from dataclasses import fields, replace

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.optics import LENS_NAMES, Camera, FlatPort, Lens

STEP = 1e-30  # of complex-step differentiation: no cancellation, so it may be tiny
INCH = 0.0254
WITH = ["walk", "window", "water", "walk and water"]
AIR_PORT = FlatPort(0.006, 1.5, 0.01)


def camera(law, rng, what):
    k = {"perspective": 350.0, "equisolid-angle": 800.0, "stereographic": 700.0}.get(law, 430.0) * rng.uniform(0.9, 1.2)
    c1, c2 = rng.uniform(-0.03, 0.03, 2)
    polynomial = tuple(rng.uniform(-0.03, 0.03, 2)) if law == "polynomial" else ()
    lens = Lens(law, k, 384.0, c1, c2, polynomial)
    walk = tuple(rng.uniform(-2e-3, 2e-3, rng.integers(1, 3))) if "walk" in what else ()
    medium = rng.uniform(1.2, 1.5) if "water" in what else 1.0
    port = None
    if what != "walk":  # far enough ahead that the pupil walks behind the glass
        port = FlatPort(rng.uniform(0, 0.02), rng.uniform(1.3, 1.9), rng.uniform(0.02, 0.05), medium)
    centre = (rng.uniform(480, 540), rng.uniform(350, 420))
    return Camera(1024, 768, lens, centre, rng.uniform(0.9, 1.1), walk, port)


def pixels(rng, cam, n=300):
    """Everywhere in the image, the principal point included."""
    u, v = rng.uniform(-1, 1024, n), rng.uniform(-1, 768, n)
    u[0], v[0] = cam.principal_point
    return u, v


def altered(thing, **changes):
    """A copy with other values, complex ones included, which the checks of a constructor would refuse."""
    copy = object.__new__(type(thing))
    for field in fields(thing):
        object.__setattr__(copy, field.name, changes.get(field.name, getattr(thing, field.name)))
    return copy


def with_step(cam, name):
    """`cam` with an imaginary step on one parameter."""
    name, step = name.removeprefix("camera."), np.complex128(1j * STEP)
    if name == "aspect":
        return altered(cam, aspect=cam.aspect + step)
    if name.startswith("port_"):
        name = name.removeprefix("port_")
        return altered(cam, port=altered(cam.port, **{name: getattr(cam.port, name) + step}))
    if name.startswith("pupil_walk_"):
        return altered(cam, pupil_walk=stepped(cam.pupil_walk, int(name[11:]) // 2 - 1))
    if name.startswith("principal_point_"):
        return altered(cam, principal_point=stepped(cam.principal_point, "uv".index(name[-1])))
    if name.startswith("polynomial_"):
        polynomial = stepped(cam.lens.polynomial, (int(name[11:]) - 3) // 2)
        return altered(cam, lens=altered(cam.lens, polynomial=polynomial))
    return altered(cam, lens=altered(cam.lens, **{name: getattr(cam.lens, name) + step}))


def stepped(values, index):
    return tuple(value + np.complex128(1j * STEP) * (i == index) for i, value in enumerate(values))


def traced(zenith, start, port):
    """Where a ray meets the outer face (off axis, ahead) and its zenith beyond: plate faces met one after the other."""
    off_axis = (port.distance - start) * np.tan(zenith)
    inside = np.arcsin(np.sin(zenith) / port.index)
    off_axis += port.thickness * np.tan(inside)
    return off_axis, port.distance + port.thickness, np.arcsin(port.index * np.sin(inside) / port.medium_index)


def test_rays_leave_a_port_as_one_traced_through_its_two_faces():
    rng = np.random.default_rng(1)
    for _ in range(200):
        cam = camera("equidistant", rng, "walk and water")
        bare = replace(cam, pupil_walk=(), port=None)
        u, v = pixels(rng, cam, 20)
        central, rays = bare.unproject(u, v).direction, cam.unproject(u, v)
        for before, origin, direction in zip(central, rays.origin, rays.direction, strict=True):
            zenith = np.arctan2(np.hypot(before[0], before[1]), before[2])
            if zenith > 1.5:
                continue  # tangents of the witness lose digits
            start = sum(d * zenith ** (2 * i + 2) for i, d in enumerate(cam.pupil_walk))
            off_axis, ahead, beyond = traced(zenith, start, cam.port)
            azimuth = np.arctan2(before[1], before[0])
            expected = np.sin(beyond) * np.cos(azimuth), np.sin(beyond) * np.sin(azimuth), np.cos(beyond)
            assert np.allclose(direction, expected, rtol=0, atol=1e-14)
            at_face = origin + (ahead - origin[2]) / direction[2] * direction
            face = off_axis * np.cos(azimuth), off_axis * np.sin(azimuth), ahead
            assert np.allclose(at_face, face, rtol=1e-12, atol=1e-15 / np.cos(zenith))


def test_two_millimetres_of_pupil_walk_at_three_inches_are_2_6_percent_of_the_radius():
    lens, zenith, baseline = Lens("equidistant", 430.0, 384.0), 1.0, 3 * INCH
    walking = Camera(1024, 768, lens, (512.0, 384.0), pupil_walk=(2e-3 / zenith**2,))
    (origin,), (direction,) = walking.unproject([512 + 430 * zenith], [384.0])
    radius = (origin + (baseline - origin[2]) / direction[2] * direction)[0]
    assert origin == pytest.approx([0, 0, 2e-3], rel=1e-14)
    assert 1 - radius / (baseline * np.tan(zenith)) == pytest.approx(0.026, abs=5e-4)


def test_a_window_in_air_moves_rays_and_does_not_turn_them():
    """A plate of index n shifts a paraxial image by t (1 - 1/n), whatever its distance."""
    cam = Camera(1024, 768, Lens("sine-law", 571.0, 384.0), (512.0, 384.0))
    u, v = pixels(np.random.default_rng(2), cam)
    near, far = (replace(cam, port=FlatPort(0.006, 1.5, distance)).unproject(u, v) for distance in (0.0, 0.3))
    assert np.array_equal(near.direction, cam.unproject(u, v).direction)
    assert np.allclose(near.origin, far.origin, rtol=0, atol=1e-17)
    assert near.origin[0] == pytest.approx([0, 0, 0.006 * (1 - 1 / 1.5)], rel=1e-14)
    assert (near.origin[1:, 2] > near.origin[0, 2]).all()


@pytest.mark.parametrize("law", LENS_NAMES)
def test_a_port_of_no_thickness_in_air_and_a_pupil_that_stands_are_no_port_and_no_walk(law):
    rng = np.random.default_rng(3)
    cam = replace(camera(law, rng, "walk"), pupil_walk=())
    u, v = pixels(rng, cam)
    plain = cam.unproject(u, v)
    passes = plain.direction[:, 2] > 0
    for same in (replace(cam, port=FlatPort(0.0, 1.5, 0.02)), replace(cam, pupil_walk=(0.0, 0.0))):
        rays = same.unproject(u, v)
        assert np.array_equal(rays.direction[passes], plain.direction[passes])
        assert np.array_equal(rays.origin[passes], plain.origin[passes])
        points = 3 * plain.direction[plain.direction[:, 2] > 0.02]
        assert np.allclose(same.project(points), cam.project(points), rtol=0, atol=1e-9)


@pytest.mark.parametrize("law", LENS_NAMES)
@pytest.mark.parametrize("what", WITH)
def test_a_point_on_a_ray_is_seen_where_the_ray_came_through_however_far(law, what):
    rng = np.random.default_rng(4)
    for _ in range(8):
        cam = camera(law, rng, what)
        u, v = pixels(rng, cam)
        rays = cam.unproject(u, v)
        grazing = rays.direction[:, 2] < (-2 if cam.port is None else 0.02)  # a port bends all grazing rays into one
        if cam.port is not None and cam.port.medium_index > 1:
            bare = replace(cam, pupil_walk=(), port=None).unproject(u, v)
            grazing |= bare.direction[:, 2] < 0.02
        seen = np.isfinite(rays.direction[:, 0]) & ~grazing
        assert seen.mean() > 0.35
        face = 0.0
        if cam.port is not None:
            face = (cam.port.outer_face - rays.origin[seen, 2]) / rays.direction[seen, 2]
        distance = face + 10 ** rng.uniform(-1.3, 1.5, seen.sum())
        points = rays.origin[seen] + distance[:, None] * rays.direction[seen]
        assert np.allclose(cam.project(points), (u[seen], v[seen]), rtol=0, atol=1e-9)


@pytest.mark.parametrize("law", LENS_NAMES)
@pytest.mark.parametrize("what", WITH)
def test_sensitivities_of_origin_and_direction_are_exact(law, what):
    rng = np.random.default_rng(5)
    for _ in range(3):
        cam = camera(law, rng, what)
        u, v = pixels(rng, cam)
        origin, direction, *slopes = cam.unproject_with_sensitivities(u, v)
        plain = cam.unproject(u, v)
        assert np.array_equal(origin, plain.origin, equal_nan=True)
        assert np.array_equal(direction, plain.direction, equal_nan=True)
        with np.errstate(invalid="ignore"):  # complex NaN divided by complex NaN, outside the lens
            moved = [cam.unproject(u + 1j * STEP, v), cam.unproject(u, v + 1j * STEP)]
            moved += [with_step(cam, name).unproject(u, v) for name in cam.parameter_names]
        well = (direction[:, 2] > 0.1) | (cam.port is None) & np.isfinite(direction[:, 0])
        well[0] = True  # the principal point: regular, though complex step cannot take the root of a squared step
        for part in (0, 1):
            ours = np.concatenate([slopes[part], slopes[part + 2]], axis=2)
            assert ours.shape == (u.size, 3, 2 + len(cam.parameter_names))
            witness = np.stack([rays[part].imag / STEP for rays in moved], axis=2)
            assert np.array_equal(np.isnan(ours).any((1, 2)), np.isnan(direction[:, 0]))
            size = np.linalg.norm(witness[well], axis=1, keepdims=True)
            scale = np.maximum(size, 1e-6 * np.abs(witness[well]).max((0, 1), keepdims=True))
            worst = np.abs(ours[well] - witness[well]) / np.where(scale > 0, scale, 1)
            print(law, what, part, worst[1:].max(), worst[0].max())
            if worst[0].max()>1e-12:
                i,j=np.unravel_index(worst[0].argmax(),worst[0].shape); print(('u','v',*cam.parameter_names)[j],i,ours[0,:,j],witness[0,:,j],size[0,0,j],scale[0,0,j])

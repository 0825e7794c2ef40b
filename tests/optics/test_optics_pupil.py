"""The pupil that walks and the flat port: where camera rays really start, and how they leave the housing."""

from dataclasses import fields, replace

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.optics import LENS_NAMES, Camera, FlatPort, Lens

STEP = 1e-30  # of complex-step differentiation: no cancellation, so it may be tiny
INCH = 0.0254
WITH = ["walk", "window", "water", "walk and water"]


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


def zenith_in_air(cam, u, v):
    """The zenith at which the lens takes rays in, behind the port; NaN outside the lens."""
    direction = replace(cam, pupil_walk=(), port=None).unproject(u, v).direction
    return np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])


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
            if not zenith < 1.5:
                continue  # outside the lens, or where tangents lose digits
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
    assert np.array_equal(near.direction, cam.unproject(u, v).direction, equal_nan=True)
    assert np.allclose(near.origin, far.origin, rtol=0, atol=1e-17, equal_nan=True)
    assert near.origin[0] == pytest.approx([0, 0, 0.006 * (1 - 1 / 1.5)], rel=1e-14)
    assert np.nanargmin(near.origin[:, 2]) == 0  # and oblique ones by more


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
        seen = np.isfinite(rays.direction[:, 0])
        if cam.port is not None:
            seen &= zenith_in_air(cam, u, v) < 1.55  # a port bends all grazing rays into one
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
        well = zenith_in_air(cam, u, v) < 1.4  # amplified rounding at the ends of lens and port: 1e-11
        for part in (0, 1):
            ours = np.concatenate([slopes[part], slopes[part + 2]], axis=2)
            assert ours.shape == (u.size, 3, 2 + len(cam.parameter_names))
            witness = np.stack([np.imag(rays[part]) / STEP for rays in moved], axis=2)
            assert np.array_equal(np.isnan(ours).any((1, 2)), np.isnan(direction[:, 0]))
            size = np.linalg.norm(witness[well], axis=1, keepdims=True)
            size = np.maximum(size, 1e-3 * size.max(0))  # where a parameter moves nothing, rounding does
            assert (np.abs(ours[well] - witness[well]) <= 1e-12 * size).all()


@pytest.mark.parametrize("what", WITH)
def test_a_point_has_a_pixel_exactly_where_some_ray_comes_from_it(what):
    """The ray of what `project` finds passes through the point; what it refuses no scan of rays finds."""
    rng = np.random.default_rng(6)
    for _ in range(6):
        cam = replace(camera("stereographic", rng, what), aspect=1.0, principal_point=(0.0, 0.0))
        points = np.stack([rng.uniform(0, 0.5, 200), np.zeros(200), rng.uniform(-0.3, 0.5, 200)], axis=1)
        points = points[np.linalg.norm(points, axis=1) > 0.08]
        u, v = cam.project(points)
        found = np.isfinite(u)
        assert 0.2 < found.mean() < 0.999
        origin, direction = cam.unproject(u[found], v[found])
        assert np.abs(np.cross(points[found] - origin, direction)).max() < 1e-13
        scan = cam.unproject(np.geomspace(1e-3, 1e6, 4000), np.zeros(4000))
        within = np.isfinite(scan.direction[:, 0])
        face = cam.port.outer_face if cam.port is not None else -np.inf
        for point in points[~found & (points[:, 2] > face)]:
            passing = np.cross(point - scan.origin[within], scan.direction[within])[:, 1]
            assert (np.sign(passing) == np.sign(passing[0])).all()


def test_what_lies_behind_in_the_glass_or_outside_snells_window_has_no_pixel():
    water = FlatPort(0.01, 1.5, 0.0, 4 / 3)
    cam = Camera(1024, 768, Lens("equidistant", 430.0, 384.0), (512.0, 384.0), port=water)
    widest = 0.01 / np.sqrt(1.5**2 - 1) + 1.0 / np.sqrt((4 / 3) ** 2 - 1)  # 1 m beyond the glass, grazing ray inside
    beyond = [[widest * 0.99, 0, 1.01], [widest * 1.01, 0, 1.01], [0, 0, 0.005], [0, 0, -1], [np.nan, 0, 1], [0, 0, 1]]
    u, v = cam.project(np.array(beyond))
    assert np.array_equal(np.isnan(u), [False, True, True, True, True, False])
    assert (u[5], v[5]) == (512.0, 384.0)
    zenith = np.array([1.5, np.pi / 2 + 0.01, 2.0])
    rays = cam.unproject(512 + 430 * zenith, np.full(3, 384.0))
    assert np.array_equal(np.isnan(rays.direction[:, 0]), [False, True, True])


def test_walk_and_port_add_their_parameters_and_the_central_camera_has_none():
    plain = Camera(1024, 768, Lens("sine-law", 571.0, 384.0), (512.0, 384.0))
    full = replace(plain, pupil_walk=(1e-3, -1e-4), port=FlatPort(0.006, 1.5))
    assert plain.parameter_names[-1] == "camera.principal_point_v"
    assert full.parameter_names[len(plain.parameter_names) :] == (
        "camera.pupil_walk_2",
        "camera.pupil_walk_4",
        "camera.port_thickness",
        "camera.port_index",
        "camera.port_distance",
        "camera.port_medium_index",
    )


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"thickness": -0.001}, "thickness must be 0 to 1 m, got -0.001 m"),
        ({"thickness": 6.0}, "thickness must be 0 to 1 m, got 6.0 m; give it in metres"),
        ({"thickness": np.nan}, "thickness must be 0 to 1 m, got nan"),
        ({"distance": -0.1}, "distance must be 0 to 10 m"),
        ({"index": 0.0}, "index must be 0.9 to 5, got 0.0; air is 1, water 1.333, glass about 1.5"),
        ({"medium_index": np.inf}, "medium_index must be 0.9 to 5"),
    ],
)
def test_an_impossible_port_is_refused_with_a_sentence(arguments, sentence):
    with pytest.raises(InputError, match=sentence):
        FlatPort(**({"thickness": 0.006, "index": 1.5} | arguments))


@pytest.mark.parametrize("walk", [(2.0,), (1e-3, np.nan), (-np.inf,)])
def test_an_impossible_pupil_walk_is_refused_with_a_sentence(walk):
    with pytest.raises(InputError, match=r"Pupil walk coefficients must lie within 1 m, got .* give them in metres"):
        Camera(1024, 768, Lens("sine-law", 571.0, 384.0), (512.0, 384.0), pupil_walk=walk)

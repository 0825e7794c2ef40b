"""The heart against closed forms, published numbers, exact derivatives and independent truth."""

import time
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from calibore.geometry import xy_of
from calibore.lasers import Plane
from calibore.optics import LENS_NAMES, Camera, Lens
from calibore.rigs import Laser, Rig, project_ring, read_rig, triangulate
from calibore.status import Status
from calibore.uncertainty import Covariance, propagate

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
STEP = 1e-30  # of complex-step differentiation: no cancellation, so it may be tiny
INVERSE = {
    "perspective": np.arctan,
    "stereographic": lambda ratio: 2 * np.arctan(ratio),
    "equidistant": lambda ratio: ratio,
    "sine-law": np.arcsin,
    "equisolid-angle": lambda ratio: 2 * np.arcsin(ratio),
}


def random_rig(rng, law, *, ideal=False):
    """A rig that sees a ring of radius 0.15 m at about 300 px from the principal point."""
    baseline = 0.15 * rng.uniform(0.6, 4)
    polynomial = tuple(rng.uniform(-0.02, 0.02, 2)) if law == "polynomial" else ()
    k = 300 / float(Lens(law, 1.0, 384.0, polynomial=polynomial).image_radius(np.arctan(0.15 / baseline)))
    c1, c2 = (0.0, 0.0) if ideal else rng.uniform(-0.03, 0.03, 2)
    centre, aspect = (rng.uniform(490, 530), rng.uniform(365, 400)), 1.0 if ideal else rng.uniform(0.95, 1.05)
    camera = Camera(1024, 768, Lens(law, k, 384.0, c1, c2, polynomial), centre, aspect)
    return Rig("perpendicular-plane", camera, (Laser(Plane(baseline, *rng.uniform(-0.08, 0.08, 2))),))


def altered(thing, **changes):
    """A copy with other values, complex ones included, which the checks of a constructor would refuse."""
    copy = object.__new__(type(thing))
    for field in fields(thing):
        object.__setattr__(copy, field.name, changes.get(field.name, getattr(thing, field.name)))
    return copy


def with_imaginary(rig, path):
    """`rig` with an imaginary step on one parameter."""
    (part, name), step, camera = path.split("."), np.complex128(1j * STEP), rig.camera
    if part == "laser":
        surface = rig.lasers[0].surface
        moved = altered(surface, **{name: getattr(surface, name) + step})
        return altered(rig, lasers=(altered(rig.lasers[0], surface=moved),))
    if name.startswith("principal_point"):
        centre = tuple(p + step * (axis == name[-1]) for axis, p in zip("uv", camera.principal_point, strict=True))
        return altered(rig, camera=altered(camera, principal_point=centre))
    if name == "aspect":
        return altered(rig, camera=altered(camera, aspect=camera.aspect + step))
    if name.startswith("polynomial_"):
        which = (int(name[-1]) - 3) // 2
        values = {"polynomial": tuple(p + step * (i == which) for i, p in enumerate(camera.lens.polynomial))}
    else:
        values = {name: getattr(camera.lens, name) + step}
    return altered(rig, camera=altered(camera, lens=altered(camera.lens, **values)))


def slopes(rig, u, v):
    """Imaginary parts of (x, y, z, radius, clock) of a complex triangulation, (n, 5)."""
    with np.errstate(invalid="ignore"):  # complex NaN divided by complex NaN, where nothing is measured
        points = triangulate(rig, u, v).points
        x, y = points[:, 0], points[:, 1]
        turned = (x.real * y.imag - y.real * x.imag) / np.abs(x.real**2 + y.real**2)
        return np.column_stack([points.imag, np.sqrt(x * x + y * y).imag, turned]) / STEP


@pytest.mark.parametrize("law", LENS_NAMES)
def test_a_wall_point_seen_in_the_image_is_triangulated_back_to_itself(law):
    rng = np.random.default_rng(1)
    for _ in range(25):
        rig = random_rig(rng, law)
        surface = rig.lasers[0].surface
        clock, radius = rng.uniform(0, 2 * np.pi, 300), 0.15 * rng.uniform(0.5, 1.3, 300)
        x, y = xy_of(clock, radius)
        z = surface.baseline + surface.tilt_x * x + surface.tilt_y * y
        result = triangulate(rig, *rig.camera.project(np.column_stack([x, y, z])))
        assert (result.status == Status.OK).all()
        assert np.allclose(result.points, np.column_stack([x, y, z]), rtol=0, atol=1e-11 * 0.15)
        assert np.allclose(result.radius, radius, rtol=1e-11)
        assert np.allclose(np.exp(1j * result.clock), np.exp(1j * clock), atol=1e-11)


@pytest.mark.parametrize("law", INVERSE)
def test_radius_agrees_with_the_closed_form_of_the_tilted_plane(law):
    """R = D tan(theta) / (1 - tan(theta) (tx cos(phi) + ty sin(phi))): Swanbom 2007, eq. 4-12, in tilts."""
    rng = np.random.default_rng(2)
    for _ in range(25):
        rig = random_rig(rng, law, ideal=True)
        azimuth, image_radius = rng.uniform(0, 2 * np.pi, 200), rng.uniform(5, 330, 200)
        u = rig.camera.principal_point[0] + image_radius * np.cos(azimuth)
        v = rig.camera.principal_point[1] + image_radius * np.sin(azimuth)
        tangent = np.tan(INVERSE[law](image_radius / rig.camera.lens.k))
        plane = rig.lasers[0].surface
        across = plane.tilt_x * np.cos(azimuth) + plane.tilt_y * np.sin(azimuth)
        witness = plane.baseline * tangent / (1 - tangent * across)
        result = triangulate(rig, u, v)
        lit = result.status == Status.OK
        assert lit.mean() > 0.9
        assert np.allclose(result.radius[lit], witness[lit], rtol=1e-9)
        assert np.allclose(result.axial[lit], (witness / tangent)[lit], rtol=1e-9)


@pytest.mark.parametrize("law", LENS_NAMES)
def test_sensitivities_are_the_exact_derivatives_wherever_the_ray_is_aimed(law):
    rng = np.random.default_rng(3)
    for _ in range(8):
        rig = random_rig(rng, law)
        u, v = rng.uniform(0, 1024, 250), rng.uniform(0, 768, 250)
        result = triangulate(rig, u, v)
        coordinates = [
            *((result.d_pixel[:, i], result.d_parameters[:, i]) for i in range(3)),
            result.radius_sensitivities,
            result.clock_sensitivities,
        ]
        witnesses = [slopes(rig, u + 1j * STEP, v), slopes(rig, u, v + 1j * STEP)]
        witnesses += [slopes(with_imaginary(rig, name), u, v) for name in result.parameter_names]
        measured = result.status == Status.OK
        moves = np.linalg.norm(np.concatenate([result.d_pixel, result.d_parameters], axis=2), axis=1)
        for c, (by_pixel, by_parameters) in enumerate(coordinates):
            ours, witness = np.column_stack([by_pixel, by_parameters]), np.column_stack([w[:, c] for w in witnesses])
            assert np.array_equal(np.isfinite(ours).all(axis=1), measured)
            size = moves / result.radius[:, None] if c == 4 else moves  # of the point, or as an angle
            assert np.abs((ours - witness)[measured] / size[measured]).max() < 1e-10


def test_axial_sensitivities_are_those_of_z():
    rig = random_rig(np.random.default_rng(4), "sine-law")
    result = triangulate(rig, [700.0, 300.0], [500.0, 200.0])
    assert np.array_equal(result.axial_sensitivities.pixel, result.d_pixel[:, 2])
    assert np.array_equal(result.axial_sensitivities.parameters, result.d_parameters[:, 2])


@pytest.mark.parametrize(("baseline", "printed"), [(0.5, 0.0532), (1.0, 0.0351), (2.0, 0.0308), (5.0, 0.0309)])
def test_the_predicted_uncertainties_of_the_dissertation_are_reproduced(baseline, printed):
    """Swanbom 2007, Table 8.3 [in]: R0 = 6 in, 768 px over the field of view for 2 R0, 1 px, u(D) = 0.001 R0."""
    k = 768 / (2 * np.arctan(2 / baseline))
    camera = Camera(1024, 768, Lens("equidistant", k, 384.0), (512.0, 384.0))
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(6 * baseline)),))
    _, u, v = project_ring(rig, 6.0, 12)
    result = triangulate(rig, u, v)
    by_pixel, by_parameters = result.radius_sensitivities
    outwards = np.array([np.sin(result.clock), -np.cos(result.clock)]).T
    u_image = np.abs((by_pixel * outwards).sum(axis=1)) * 1.0
    u_baseline = propagate(
        by_parameters, Covariance.independent({"laser.baseline": 0.006}), names=result.parameter_names
    ).u
    assert np.allclose(np.hypot(u_image, u_baseline), printed, rtol=0, atol=0.5e-4)  # half the last printed digit


@pytest.mark.parametrize("case", ["field", "plane-3in", "plane-6in", "plane-12in", "plane-30in"])
def test_the_independent_renderer_sees_the_same_wall_points(case):
    if not SIMULATED.is_dir():
        pytest.skip(f"{SIMULATED} is absent: triangulation is not checked against the independent renderer")
    truth, inch = np.load(SIMULATED / case / "truth.npz"), 0.0254
    seen = truth["line_visible"]
    u, v, radius, clock, axial = (
        truth[f"line_{name}"][seen].astype(float) for name in ("u", "v", "rig_R", "rig_phi", "rig_H")
    )
    rig = read_rig(SIMULATED / case / "rig.toml")
    result = triangulate(rig, u, v)
    assert u.size > 10_000
    assert (result.status == Status.OK).all()
    pixel = 2e-4  # float32 rounding of u, v up to 1024 px, and as much again for radius and clock
    assert np.abs(result.radius - radius * inch).max() < pixel * np.abs(result.d_pixel).max()
    assert np.abs(result.axial - axial * inch).max() < 1e-5 * inch
    assert np.abs(np.angle(np.exp(1j * (result.clock - clock)))).max() < 2e-6
    x, y = xy_of(clock, radius)
    again = rig.camera.project(np.column_stack([x, y, axial]))
    assert np.abs(np.subtract(again, (u, v))).max() < pixel


def test_a_pixel_that_measures_nothing_says_why_and_is_nan_throughout():
    camera = Camera(1000, 800, Lens("stereographic", 150.0, 400.0), (500.0, 400.0))
    tilted = Rig("perpendicular-plane", camera, (Laser(Plane(0.2, tilt_x=0.0)),))
    edge = 150 * np.tan(np.pi / 4)  # the ray at a right angle to the axis is parallel to the plane
    result = triangulate(tilted, [np.nan, 500 + edge, 500 + 1.5 * edge, 560.0], [400.0] * 4)
    assert result.status.tolist() == [Status.NO_PEAK, Status.GRAZING, Status.BEHIND, Status.OK]
    for array in (result.points, result.d_pixel, result.d_parameters, result.radius_sensitivities.pixel):
        assert np.isnan(array[:3]).all()
        assert np.isfinite(array[3]).all()
    sine = Rig("perpendicular-plane", Camera(1000, 800, Lens("sine-law", 300.0, 400.0), (500.0, 400.0)), tilted.lasers)
    assert triangulate(sine, 801.0, 400.0).status.tolist() == [Status.OUTSIDE_LENS]


def test_no_pixel_at_all_gives_an_empty_result():
    result = triangulate(random_rig(np.random.default_rng(5), "equidistant"), [], [])
    assert result.points.shape == (0, 3)
    assert result.radius_sensitivities.parameters.shape == (0, len(result.parameter_names))


def test_a_projected_ring_is_triangulated_to_its_radius():
    rng = np.random.default_rng(6)
    for law in LENS_NAMES:
        rig = random_rig(rng, law)
        clock, u, v = project_ring(rig, 0.15, 400)
        result = triangulate(rig, u, v)
        assert np.allclose(result.radius, 0.15, rtol=1e-11)
        assert np.allclose(np.exp(1j * result.clock), np.exp(1j * clock), atol=1e-11)
        assert clock[0] == 0
        assert v[0] < rig.camera.principal_point[1]  # the crown is at the top of the image


def test_fifteen_hundred_points_with_sensitivities_take_about_a_millisecond():
    rig = random_rig(np.random.default_rng(7), "equisolid-angle")
    _, u, v = project_ring(rig, 0.15, 1500)
    times = []
    for _ in range(20):
        start = time.perf_counter()
        _ = triangulate(rig, u, v).radius_sensitivities
        times.append(time.perf_counter() - start)
    assert min(times) < 0.006  # 0.6 ms measured; room for a busy machine

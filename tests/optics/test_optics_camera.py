"""Pixel to ray and back, for every lens law."""

from dataclasses import fields

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.optics import LENS_NAMES, Camera, Lens
from calibore.optics._odd_polynomial import OddPolynomial

STEP = 1e-30  # of complex-step differentiation: no cancellation, so it may be tiny


def camera(law, rng, *, residual=True):
    k = {"perspective": 350.0, "equisolid-angle": 800.0, "stereographic": 700.0}.get(law, 430.0) * rng.uniform(0.9, 1.2)
    c1, c2 = rng.uniform(-0.03, 0.03, 2) if residual else (0.0, 0.0)
    polynomial = tuple(rng.uniform(-0.03, 0.03, 2)) if law == "polynomial" else ()
    lens = Lens(law, k, 384.0, c1, c2, polynomial)
    return Camera(1024, 768, lens, (rng.uniform(480, 540), rng.uniform(350, 420)), rng.uniform(0.9, 1.1))


def altered(thing, **changes):
    """A copy with other values, complex ones included, which the checks of a constructor would refuse."""
    copy = object.__new__(type(thing))
    for field in fields(thing):
        object.__setattr__(copy, field.name, changes.get(field.name, getattr(thing, field.name)))
    return copy


def with_imaginary(camera, name):
    """`camera` with an imaginary step on one parameter."""
    name, step = name.removeprefix("camera."), np.complex128(1j * STEP)
    if name.startswith("principal_point"):
        axis = "uv".index(name[-1])
        return altered(
            camera, principal_point=tuple(p + step * (i == axis) for i, p in enumerate(camera.principal_point))
        )
    if name == "aspect":
        return altered(camera, aspect=camera.aspect + step)
    if name.startswith("polynomial_"):
        index = (int(name.split("_")[1]) - 3) // 2
        coefficients = tuple(c + step * (i == index) for i, c in enumerate(camera.lens.polynomial))
        return altered(camera, lens=altered(camera.lens, polynomial=coefficients))
    return altered(camera, lens=altered(camera.lens, **{name: getattr(camera.lens, name) + step}))


def slope(camera, u, v):
    with np.errstate(invalid="ignore"):  # complex NaN divided by complex NaN, outside the lens
        return camera.unproject(u, v).direction.imag / STEP


def pixels(rng, n=400):
    """Everywhere in the image, its corners and the principal row and column included."""
    return rng.uniform(-1, 1024, n), rng.uniform(-1, 768, n)


@pytest.mark.parametrize("law", LENS_NAMES)
def test_a_ray_hits_the_pixel_it_came_through(law):
    rng = np.random.default_rng(1)
    for residual in (False, True):
        for _ in range(10):
            cam, (u, v) = camera(law, rng, residual=residual), pixels(rng)
            rays = cam.unproject(u, v).direction
            seen = np.isfinite(rays[:, 0])
            assert seen.mean() > 0.4
            again = cam.project(rays[seen] * rng.uniform(0.1, 10, (seen.sum(), 1)))
            assert np.allclose(again, (u[seen], v[seen]), rtol=0, atol=1e-10)  # 5e-13 measured: rounding
            assert np.allclose(np.linalg.norm(rays[seen], axis=1), 1, rtol=0, atol=1e-14)


FORWARD = {
    "perspective": np.tan,
    "stereographic": lambda zenith: np.tan(zenith / 2),
    "equidistant": lambda zenith: zenith,
    "sine-law": np.sin,
    "equisolid-angle": lambda zenith: np.sin(zenith / 2),
}


@pytest.mark.parametrize("law", FORWARD)
def test_the_five_laws_and_the_residual_are_those_of_the_contract(law):
    zenith = np.linspace(0.01, 1.2, 50)
    radius = 500.0 * FORWARD[law](zenith)
    q = radius / 384.0
    assert np.allclose(Lens(law, 500.0, 384.0).image_radius(zenith), radius, rtol=1e-14)
    bent = Lens(law, 500.0, 384.0, -0.004, 0.001)
    assert np.allclose(bent.image_radius(zenith), radius * (1 - 0.004 * q**2 + 0.001 * q**4), rtol=1e-13)


def test_the_polynomial_law_is_an_odd_polynomial_of_the_zenith():
    zenith = np.linspace(0, 1.4, 60)
    lens = Lens("polynomial", 400.0, 384.0, polynomial=(-0.05, 0.01))
    assert np.allclose(lens.image_radius(zenith), 400 * (zenith - 0.05 * zenith**3 + 0.01 * zenith**5), rtol=1e-13)
    assert np.allclose(lens.zenith(lens.image_radius(zenith)), zenith, atol=1e-13)


def test_azimuth_runs_from_u_towards_v_and_aspect_stretches_v():
    cam = Camera(1000, 800, Lens("equidistant", 500.0, 400.0), (500.0, 400.0), 1.1)
    right, down = cam.unproject([600.0, 500.0], [400.0, 510.0]).direction
    assert np.allclose(right, [np.sin(0.2), 0, np.cos(0.2)])
    assert np.allclose(down, [0, np.sin(0.2), np.cos(0.2)])


@pytest.mark.parametrize("law", LENS_NAMES)
@pytest.mark.parametrize("residual", [False, True])
def test_sensitivities_of_a_ray_are_exact(law, residual):
    rng = np.random.default_rng(2)
    for _ in range(5):
        cam, (u, v) = camera(law, rng, residual=residual), pixels(rng)
        _, rays, _, d_pixel, _, d_parameters = cam.unproject_with_sensitivities(u, v)
        assert np.array_equal(rays, cam.unproject(u, v).direction, equal_nan=True)
        assert d_parameters.shape == (u.size, 3, len(cam.parameter_names))
        pairs = [(d_pixel[:, :, 0], slope(cam, u + 1j * STEP, v)), (d_pixel[:, :, 1], slope(cam, u, v + 1j * STEP))]
        for i, name in enumerate(cam.parameter_names):
            pairs.append((d_parameters[:, :, i], slope(with_imaginary(cam, name), u, v)))
        for ours, witness in pairs:
            assert np.array_equal(np.isnan(ours), np.isnan(rays))
            size = np.linalg.norm(np.nan_to_num(witness), axis=1, keepdims=True) + 1e-9
            assert np.nanmax(np.abs(ours - witness) / size) < 1e-9  # rounding, amplified near the end of the lens


def test_the_ray_through_the_principal_point_has_finite_sensitivities():
    cam = Camera(1000, 800, Lens("sine-law", 500.0, 400.0, -0.01), (500.0, 400.0))
    _, ray, _, d_pixel, _, d_parameters = cam.unproject_with_sensitivities([500.0], [400.0])
    assert np.allclose(ray, [[0, 0, 1]])
    assert np.allclose(d_pixel[0], np.array([[1, 0], [0, 1], [0, 0]]) / 500, rtol=1e-12)
    assert np.isfinite(d_parameters).all()


@pytest.mark.parametrize(
    ("law", "edge"), [("sine-law", 300.0), ("equisolid-angle", 300.0), ("equidistant", 300 * np.pi)]
)
def test_beyond_the_end_of_the_law_there_is_no_ray(law, edge):
    lens = Lens(law, 300.0, 384.0)
    inside, outside = lens.zenith(np.array([edge * 0.999, edge * 1.001]))
    assert np.isfinite(inside)
    assert np.isnan(outside)
    assert np.isnan(lens.image_radius(lens.max_zenith + 1e-9))


def test_a_residual_that_turns_back_ends_the_lens_before_its_turning_point():
    lens = Lens("equidistant", 400.0, 384.0, c1=-0.2)
    zenith = np.linspace(0, 3.1, 500)
    radius = lens.image_radius(zenith)
    seen = np.isfinite(radius)
    assert np.array_equal(seen, zenith < lens.max_zenith)
    assert (np.diff(radius[seen]) > 0).all()
    assert np.allclose(lens.zenith(radius[seen]), zenith[seen], atol=1e-10)
    assert np.isnan(lens.zenith(np.array([np.nanmax(radius) * 1.01])))


def test_an_odd_polynomial_is_inverted_wherever_it_rises_however_wild():
    rng = np.random.default_rng(3)
    for _ in range(500):
        polynomial = OddPolynomial(tuple(rng.uniform(-0.5, 0.5, rng.integers(1, 5)) * rng.choice([1, 0.1, 1e-3])))
        x = np.linspace(0, min(polynomial.limit, 3.2), 60)[:-1]
        assert (np.diff(polynomial.value(x)) > 0).all()
        assert np.allclose(polynomial.inverse(polynomial.value(x)), x, rtol=0, atol=1e-12)


def test_what_the_lens_cannot_see_has_no_pixel():
    cam = Camera(1000, 800, Lens("perspective", 500.0, 400.0), (500.0, 400.0))
    u, v = cam.project(np.array([[0.1, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [np.nan, 0.0, 1.0]]))
    assert np.array_equal(np.isnan(u), [True, True, False, True])
    assert (u[2], v[2]) == (500.0, 400.0)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"law": "fisheye"}, "allowed: perspective, stereographic, equidistant, sine-law, equisolid-angle, polynomial"),
        ({"k": -1.0}, "k must be positive, got -1.0 px"),
        ({"k": np.nan}, "k must be positive"),
        ({"c1": np.inf}, "finite"),
        ({"polynomial": (0.1,)}, "belong to the lens law"),
        ({"law": "polynomial"}, "belong to the lens law"),
    ],
)
def test_an_impossible_lens_is_refused_with_a_sentence(arguments, sentence):
    with pytest.raises(InputError, match=sentence):
        Lens(**({"law": "sine-law", "k": 500.0, "half_height": 384.0} | arguments))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"width": 0}, "0 x 768 px"),
        ({"aspect": 0.0}, "aspect must be positive"),
        ({"principal_point": (np.nan, 0)}, "finite"),
    ],
)
def test_an_impossible_camera_is_refused_with_a_sentence(arguments, sentence):
    lens = Lens("sine-law", 500.0, 384.0)
    with pytest.raises(InputError, match=sentence):
        Camera(**({"width": 1024, "height": 768, "lens": lens, "principal_point": (512.0, 384.0)} | arguments))

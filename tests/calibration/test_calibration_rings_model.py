"""Where marks of a ring target should be, and what moves them."""

from dataclasses import replace

import numpy as np
import pytest
from calibration_ring_marks import exact_marks, random_case

from calibore.calibration._lens_models import LENS_MODELS, LensModel
from calibore.calibration._rings._model import Printed, RingModel
from calibore.calibration._rings._sight import condensed
from calibore.calibration._rings._start import start_values
from calibore.calibration._rings._target import RingTarget
from calibore.optics import Camera, Lens

SPACING = 0.0254
RADII = SPACING * np.arange(1, 9)


def _target(rng):
    return RingTarget(
        float(rng.uniform(0.1, 0.5)), *rng.normal(0, 0.05, 2), *rng.normal(0, 0.01, 2), float(rng.uniform(-3, 3))
    )


def test_a_point_on_the_target_lies_in_its_plane_at_its_radius_and_on_its_spoke():
    rng = np.random.default_rng(1)
    for _ in range(20):
        target, radius, angle = _target(rng), rng.uniform(0.001, 0.3, 50), rng.uniform(-7, 7, 50)
        points = target.point(radius, angle)
        assert np.abs(target.plane.value(points)).max() < 1e-15
        np.testing.assert_allclose(target.radius(points).value, radius, rtol=1e-12)
        assert np.abs(target.across(points, angle).value).max() < 1e-15


@pytest.mark.parametrize("place", ["radius", "across"])
def test_places_on_the_target_move_as_their_derivatives_say(place):
    rng = np.random.default_rng(2)
    target = _target(rng)
    points = target.point(rng.uniform(0.01, 0.3, 40), rng.uniform(-3, 3, 40))
    rest = () if place == "radius" else (rng.uniform(-3, 3, 40),)
    found = getattr(target, place)(points, *rest)
    step = 1e-6
    for i, name in enumerate(RingTarget.parameter_names):
        ends = [replace(target, **{name: getattr(target, name) + way * step}) for way in (1, -1)]
        slope = np.subtract(*(getattr(end, place)(points, *rest).value for end in ends)) / (2 * step)
        np.testing.assert_allclose(found.by_parameters[:, i], slope, atol=1e-8)
    for i in range(2):
        ends = [points + way * step * np.eye(3)[i] for way in (1, -1)]
        slope = np.subtract(*(getattr(target, place)(end, *rest).value for end in ends)) / (2 * step)
        np.testing.assert_allclose(found.by_point[:, i], slope, atol=1e-8)


def _values(model, camera, targets):
    lens = camera.lens
    known = {"camera.k": lens.k, "camera.c1": lens.c1, "camera.c2": lens.c2, "camera.aspect": camera.aspect}
    known |= {f"camera.polynomial_{3 + 2 * i}": value for i, value in enumerate(lens.polynomial)}
    known |= {"camera.principal_point_u": camera.principal_point[0]}
    known |= {"camera.principal_point_v": camera.principal_point[1]}
    places = [getattr(target, name) for target in targets for name in RingTarget.parameter_names]
    camera_names = [name for name in model.names if name.startswith("camera.")]
    rest = len(model.names) - len(camera_names) - len(places)
    return np.array([*(known[name] for name in camera_names), *places, *np.zeros(rest)])


LENSES = [
    Lens("stereographic", 500.0, 384.0),
    Lens("sine-law", 420.0, 384.0),
    Lens("equidistant", 330.0, 384.0, c1=0.03, c2=-0.02),
    Lens("polynomial", 350.0, 384.0, polynomial=(-0.08, 0.01)),
]


@pytest.mark.parametrize("lens", LENSES, ids=lambda lens: lens.law)
def test_marks_of_the_model_leave_no_residual_and_its_jacobian_is_the_slope_of_its_predictions(lens):
    rng = np.random.default_rng(3)
    camera = Camera(1024, 768, lens, (505.0, 390.0), aspect=1.01)
    targets = [RingTarget(0.15, 0.02, -0.01, 0.003, -0.002, 0.4), RingTarget(0.25, -0.1, 0.05, 0.0, 0.01, -2.0)]
    ink = 0.0015
    marks = tuple(exact_marks(camera, target, RADII, per_ring=16, ink_width=ink) for target in targets)
    extras = ("c1", "c2") if lens.c1 else ("polynomial_3", "polynomial_5") if lens.polynomial else ()
    model = RingModel(LensModel(lens.law, extras), Printed(RADII, 8, ink), marks, (1024, 768), printed_errors=True)
    values = _values(model, camera, targets)
    residuals, jacobian = model(values)
    # px; the ink's half width is taken from the slope a quarter of a pixel aside
    assert np.abs(residuals).max() < 1e-4
    values = values + rng.normal(0, 1e-4, values.size) * np.maximum(np.abs(values), 0.01)
    residuals, jacobian = model(values)
    for i in range(values.size):
        step = np.zeros(values.size)
        step[i] = 1e-6 * max(abs(values[i]), 0.01)
        slope = -(model(values + step)[0] - model(values - step)[0]) / (2 * step[i])
        # the ink moves marks by a hundredth of a pixel; how that changes is left out of the derivatives
        np.testing.assert_allclose(jacobian[:, i], slope, atol=2e-3 * np.abs(slope).max() + 1e-6)


def test_a_camera_that_cannot_be_leaves_no_value():
    case = random_case(np.random.default_rng(4), per_ring=40)
    model = RingModel(case.lens, case.sight.printed, case.sight.marks, case.sight.size)
    residuals, jacobian = model(-np.ones(len(model.names)))
    assert np.isnan(residuals).all()
    assert np.isnan(jacobian).all()


@pytest.mark.parametrize("nominal", [0.4, 1.0, 2.5])
def test_pictures_give_starting_values_within_a_few_pixels_whatever_is_said_of_the_distance(nominal):
    rng = np.random.default_rng(5)
    for _ in range(5):
        case = random_case(rng, per_ring=40)
        for lens in (case.lens, LensModel("polynomial", ("polynomial_3", "polynomial_5"))):
            model = RingModel(lens, case.sight.printed, case.sight.marks, case.sight.size)
            start = start_values(model, nominal * case.truth["laser.baseline"], principal_point=None)
            residuals = model(start)[0]
            # the target's tilt, its offset and the pixels' aspect are not yet known: 2 % of 350 px
            assert np.sqrt(np.nanmean(residuals**2)) < 12
            assert np.isfinite(residuals).mean() > 0.97


def test_condensed_marks_keep_the_mean_of_their_stretch_and_lose_what_disagrees():
    rng = np.random.default_rng(6)
    case = random_case(rng)
    n = case.sight.line.size
    residuals = rng.normal(0, 0.05, n)
    wild = residuals.copy()
    wild[::40] += 5.0
    short, wild_short = (condensed(case.sight, r, np.zeros(n)) for r in (residuals, wild))
    assert short.line.size < n / 15
    moved = np.concatenate([np.hypot(a.u - b.u, a.v - b.v) for a, b in zip(short.marks, wild_short.marks, strict=True)])
    # leaving one mark in twenty out moves a mean of twenty by a fifth of its standard deviation
    assert np.median(moved) < 0.01


def test_every_law_is_offered_alone_and_with_its_residual_and_the_polynomial_besides():
    names = [model.name for model in LENS_MODELS]
    assert len(set(names)) == 13
    assert "sine-law + c1, c2" in names
    assert "polynomial to power 7" in names
    for model in LENS_MODELS:
        camera = model.camera({"camera.k": 400.0}, width=640, height=480)
        assert camera.principal_point == (319.5, 239.5)
        assert set(model.parameters) <= set(camera.parameter_names)

"""docs/errata.md is true: what it says of the dissertation's equations, checked independently of the other tests."""

import pkgutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import calibore
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import profile_scan
from calibore.rigs import Laser, Rig, triangulate
from calibore.scans import open_points, open_profile
from calibore.simulation import demo_survey, simulate_scan
from calibore.stripe import area_centroid, detect_line

TACTILE = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "tactile"
STEP = 1e-30  # of complex-step differentiation: no cancellation, so it may be tiny
BASELINE, K, CENTRE = 0.3, 600.0, (512.0, 384.0)


def rig(law="equidistant", *, alpha=0.0, beta=0.0):
    """A laser plane misaligned as in chapter 4: by `alpha` in the direction `beta`, from the right with y upwards."""
    plane = Plane(BASELINE, np.tan(alpha) * np.cos(beta), -np.tan(alpha) * np.sin(beta))
    return Rig("perpendicular-plane", Camera(1024, 768, Lens(law, K, 384.0), CENTRE), (Laser(plane),))


def pixels(phi, image_radius):
    """Pixels at the dissertation's azimuth `phi` (from the right, y upwards; v runs downwards)."""
    return CENTRE[0] + image_radius * np.cos(phi), CENTRE[1] - image_radius * np.sin(phi)


def turned(result, phi, image_radius):
    """dR/dphi [m/rad] at fixed image radius, from the sensitivities to the pixel."""
    by_u, by_v = result.radius_sensitivities.pixel.T
    return -by_u * image_radius * np.sin(phi) - by_v * image_radius * np.cos(phi)


def misaligned_radius(theta, phi, alpha, beta):
    """Swanbom 2007, eq. 4-12, times R0."""
    return BASELINE * np.tan(theta) / (1 - np.tan(alpha) * np.tan(theta) * np.cos(phi - beta))


def random_misalignment(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.2, 0.6, 50), rng.uniform(0, 2 * np.pi, 50), rng.uniform(0.01, 0.1), rng.uniform(0, 2 * np.pi)


@pytest.mark.parametrize("seed", range(5))
def test_4_19_needs_the_other_sign_and_the_squared_tangent(seed):
    theta, phi, alpha, beta = random_misalignment(seed)
    exact = misaligned_radius(theta, phi + 1j * STEP, alpha, beta).imag / STEP
    factor = np.tan(alpha) * np.sin(phi - beta) * (misaligned_radius(theta, phi, alpha, beta) / np.tan(theta)) ** 2
    assert np.allclose(-(np.tan(theta) ** 2) * factor / BASELINE, exact, rtol=1e-12)
    printed = np.sin(theta) ** 2 * factor / BASELINE
    assert (np.sign(printed) == -np.sign(exact)).all()
    ours = turned(triangulate(rig(alpha=alpha, beta=beta), *pixels(phi, K * theta)), phi, K * theta)
    assert np.allclose(ours, exact, rtol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_4_12_is_the_tilted_plane_of_the_contract(seed):
    theta, phi, alpha, beta = random_misalignment(seed)
    result = triangulate(rig(alpha=alpha, beta=beta), *pixels(phi, K * theta))
    assert np.allclose(result.radius, misaligned_radius(theta, phi, alpha, beta), rtol=1e-12)


def test_4_22_loses_the_misalignment_at_zero_where_tilts_keep_it():
    """dR/dbeta = 0 at alpha = 0, so that no U[beta] shows there; dR/dtilt = (R^2 / D) cos(phi - direction) remains."""
    phi, theta = np.linspace(0, 2 * np.pi, 40), 0.45
    result = triangulate(rig(), *pixels(phi, np.full(40, K * theta)))
    by = dict(zip(result.parameter_names, result.radius_sensitivities.parameters.T, strict=True))
    assert np.abs(misaligned_radius(theta, phi, 0.0, 1.0 + 1j * STEP).imag).max() == 0
    assert np.allclose(by["laser.tilt_x"], result.radius**2 / BASELINE * np.cos(phi), atol=1e-12)
    assert np.allclose(by["laser.tilt_y"], -(result.radius**2) / BASELINE * np.sin(phi), atol=1e-12)


def test_4_24_noise_across_the_ray_does_not_move_the_radius_of_an_untilted_plane():
    phi = np.linspace(0, 2 * np.pi, 40)
    result = triangulate(rig(), *pixels(phi, np.full(40, 250.0)))
    assert np.abs(turned(result, phi, 250.0)).max() < 1e-12 * BASELINE


TRIG_FREE = {  # Swanbom 2007, eqs. 6-6, 6-7, 6-9, 6-10 with s = r / k, free of trigonometry
    "perspective": lambda s: s,
    "stereographic": lambda s: 2 * s / (1 - s**2),
    "equidistant": np.tan,
    "sine-law": lambda s: s / np.sqrt(1 - s**2),
    "equisolid-angle": lambda s: 2 * s * np.sqrt(1 - s**2) / (1 - 2 * s**2),
}


@pytest.mark.parametrize("law", TRIG_FREE)
def test_6_6_to_6_10_are_the_untilted_plane_under_the_five_laws(law):
    s = np.linspace(0.01, 0.55, 60)
    result = triangulate(rig(law), *pixels(np.linspace(0, 6, 60), K * s))
    assert np.allclose(result.radius, BASELINE * TRIG_FREE[law](s), rtol=1e-12)


def test_6_6_tells_the_ratio_of_baseline_and_k_only_and_the_others_tell_both():
    for law in TRIG_FREE:
        result = triangulate(rig(law), *pixels(np.linspace(0, 6, 60), np.linspace(20, 330, 60)))
        by = dict(zip(result.parameter_names, result.radius_sensitivities.parameters.T, strict=True))
        relative = np.column_stack([by["laser.baseline"] * BASELINE, by["camera.k"] * K]) / result.radius[:, None]
        assert (np.linalg.svd(relative, compute_uv=False)[1] < 1e-12) == (law == "perspective")


def exact_centroid(points):
    """Centroid of a polygon of whole coordinates as the sum of its triangles from the origin, in exact fractions."""
    area, x, y = Fraction(0), Fraction(0), Fraction(0)
    for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
        twice = Fraction(x0 * y1 - x1 * y0)
        area, x, y = area + twice / 2, x + twice * (x0 + x1) / 6, y + twice * (y0 + y1) / 6
    return float(x / area), float(y / area)


@pytest.mark.parametrize("seed", range(5))
def test_6_11_and_6_12_are_the_area_centroid_in_either_sense_of_rotation(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 30))
    radius = rng.integers(200, 400, 30)
    points = [(int(500 + r * np.cos(a)), int(400 + r * np.sin(a))) for r, a in zip(radius, angle, strict=True)]
    expected = exact_centroid(points)
    for order in (points, points[::-1], points[7:] + points[:7]):
        column, row = np.array(order, dtype=float).T
        assert np.allclose(area_centroid(column, row), expected, rtol=0, atol=1e-9)


def test_6_11_is_no_circle_centre_where_an_arc_is_missing():
    angle = np.linspace(0, 1.5 * np.pi, 400)  # the fourth quarter is cut by a chord
    column, row = 500 + 300 * np.cos(angle), 400 + 300 * np.sin(angle)
    off = np.hypot(*np.subtract(area_centroid(column, row), (500, 400)))
    segment = 2 / 3 * np.sin(np.pi / 4) ** 3  # first moment of the missing segment of a unit circle
    assert off == pytest.approx(300 * segment / (0.75 * np.pi + 0.5), rel=1e-4)


def test_the_published_peak_is_drawn_to_whole_pixels_and_the_default_is_not():
    """Line sigma 2 px, noise 1 grey value in 150: the vertex of 8 samples errs with the place within the pixel."""
    rng = np.random.default_rng(3)
    true = 60.0 + 6.0 * np.sin(np.arange(800) / 40.0)
    line = 20 + 150 * np.exp(-((np.arange(120)[:, None] - true) ** 2) / 8.0)
    image = np.clip(np.rint(line + rng.normal(0, 1, line.shape)), 0, 255).astype(np.uint8)
    rms = {}
    for estimator in ("parabola", "zero-crossing"):
        error = detect_line(image, estimator=estimator).v - true
        rms[estimator] = float(np.sqrt(np.nanmean(error**2)))
    assert 0.05 < rms["parabola"] < 0.10
    assert rms["zero-crossing"] < rms["parabola"] / 3


def test_the_mean_over_a_clock_step_is_nearer_the_truth_than_the_ray_nearest_to_it(tmp_path):
    survey = demo_survey(seed=5)
    survey = replace(survey, stated=None, stations=survey.stations[6:7])  # the rig as it truly is: noise alone is left
    profile_scan(simulate_scan(tmp_path / "scan", survey, seed=5), tmp_path / "out")
    with np.load(tmp_path / "scan" / "truth.npz") as file:
        clock, truth = file["ring_phi"][0], file["ring_rig_R"][0, 0] * 0.0254
    ring, points = open_profile(tmp_path / "out"), open_points(tmp_path / "out")
    away = np.abs(np.mod(points["clock"].values - clock[:, None] + np.pi, 2 * np.pi) - np.pi)
    nearest = points["radius"].values[np.where(np.isfinite(points["radius"].values), away, np.inf).argmin(axis=1)]
    ours, published = (np.sqrt(np.nanmean((r - truth) ** 2)) for r in (ring["radius"].values[0], nearest))
    assert ours < 0.9 * published  # some four rays a step, half of whose noise is shared


def test_7_10_mirrors_what_lies_on_the_other_side_of_the_centre_column():
    """Side-facing R of (7-12) at p = 712, constants of (7-14), D = 2.355 in, 0.0175 read as degrees per pixel."""

    def radius(sine, zenith):
        tangent = np.tan(np.radians(19.9))
        return 2.355 * (1 + sine * np.tan(zenith) * tangent) / (tangent - sine * np.tan(zenith))

    p, rows = 712.0, np.array([600.0, 168.0])
    image_radius = np.hypot(p - 512, rows - 384)
    zenith = np.radians(0.0175) * image_radius
    printed = radius(np.sin(np.arctan((512 - p) / (384 - rows))), zenith)
    right = radius((p - 512) / image_radius, zenith)
    assert np.allclose(printed, [8.004, 5.441], atol=0.0005)
    assert np.allclose(right, 8.004, atol=0.0005)
    camera = rig().camera
    above, below = camera.unproject([p, p], rows).direction
    assert np.allclose(above, below * [1, -1, 1], atol=1e-15)  # sine and cosine as ratios: no arctangent, no mirror


def test_8_1_with_a_difference_gives_the_intercept_and_as_printed_gives_no_length():
    if not TACTILE.exists():
        pytest.skip("the tactile data beside the repository (shared/data/simulated/tactile) are absent")
    raw, length = np.loadtxt(TACTILE / "probe_calibration.csv", delimiter=",", skiprows=1).T
    *_, raw1, raw2, diameter = np.loadtxt(TACTILE / "diameters.csv", delimiter=",", skiprows=1).T
    for unit in (1.0, 25.4):  # inches, millimetres
        slope = unit * np.polyfit(raw, length, 1)[0]
        intercept = (unit * diameter - slope * (raw1 + raw2)) / 2
        assert np.allclose(intercept / unit, 4.5706, atol=0.01)  # raw ratios are good to 0.001, 5 in each
        printed = unit * diameter / (2 * slope * (raw1 + raw2))
        assert np.allclose(printed, 2.37, atol=0.1)  # the same in every unit: it has none


def test_8_4_nothing_here_is_called_a_mean_squared_error():
    for package in pkgutil.iter_modules(calibore.__path__):
        if package.ispkg:
            names = __import__(f"calibore.{package.name}", fromlist=["__all__"]).__all__
            assert not [name for name in names if "mse" in name.lower() or "squared_error" in name.lower()]

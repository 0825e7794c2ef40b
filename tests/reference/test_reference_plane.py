"""Plane meetings against chapter 4 of Swanbom 2007, in the tilts (alpha, beta) of the source."""

import closed_forms as book
import numpy as np

from calibore.lasers import MeetingFlag, Plane

STEP = 1e-30
RNG = np.random.default_rng(4)
N = 400
CASES = {
    "theta": RNG.uniform(0.05, 1.3, N),
    "phi": RNG.uniform(-np.pi, np.pi, N),
    "d": RNG.uniform(0.3, 5, N),
    "alpha": RNG.uniform(-0.6, 0.6, N),
    "beta": RNG.uniform(-np.pi, np.pi, N),
}


def tilted(d, alpha, beta):
    """A plane of complex parameters too, for slopes."""
    plane = object.__new__(Plane)
    values = (d, np.tan(alpha) * np.cos(beta), -np.tan(alpha) * np.sin(beta))
    for name, value in zip(Plane.parameter_names, values, strict=True):
        object.__setattr__(plane, name, value)
    return plane


def meet(theta, phi, d, *, alpha, beta):
    """(R, H, flag) of one ray."""
    direction = book.ray(theta, phi)[None]
    meetings = tilted(d, alpha, beta).meet(np.zeros(3), direction)
    return meetings.distance[0, 0] * np.sin(theta), meetings.distance[0, 0] * np.cos(theta), meetings.flags[0, 0]


def cases():
    for i in range(N):
        yield {name: values[i] for name, values in CASES.items()}


def test_radius_and_height_are_those_of_the_closed_form_ahead_and_behind():
    ahead = 0
    for case in cases():
        radius, height, flag = meet(**case)
        expected = book.plane_radius(**case)
        np.testing.assert_allclose([radius, height], expected, rtol=1e-12)
        assert bool(flag & MeetingFlag.BEHIND) == (expected[1] < 0)
        ahead += expected[1] > 0
    assert 0.8 * N < ahead < N


def test_slopes_are_the_corrected_partial_derivatives():
    for case in cases():
        stepped = [meet(**{**case, name: case[name] + 1j * STEP})[0].imag / STEP for name in CASES]
        np.testing.assert_allclose(stepped, book.plane_slopes(**case), rtol=1e-9, atol=1e-12)


def test_the_printed_slope_by_azimuth_has_the_wrong_sign():
    wrong = [np.sign(book.turning_as_printed(**case)) != np.sign(book.plane_slopes(**case)[1]) for case in cases()]
    assert np.all(wrong)


def test_without_tilt_the_radius_is_baseline_times_tangent():
    """Eq. 4-13."""
    for case in cases():
        radius, height, _ = meet(**{**case, "alpha": 0.0})
        np.testing.assert_allclose([radius, height], [case["d"] * np.tan(case["theta"]), case["d"]], rtol=1e-13)

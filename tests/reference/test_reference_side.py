"""Sheet meetings against chapter 5 of Swanbom 2007: the side-facing head, pupil at x = baseline, sheet x = 0."""

import closed_forms as book
import numpy as np

from calibore.lasers import MeetingFlag, Sheet

STEP = 1e-30
NAMES = ("theta", "phi", "d", "alpha")


def cases(n=400):
    """Rays that meet the sheet well ahead: the field of view of the source."""
    rng = np.random.default_rng(5)
    theta, phi = rng.uniform(0.01, 0.3, n), rng.uniform(-np.pi, np.pi, n)
    d, alpha = rng.uniform(0.2, 0.9, n), rng.uniform(0.25, 0.6, n)
    kept = np.tan(alpha) - np.sin(phi) * np.tan(theta) > 0.02
    return dict(zip(NAMES, (values[kept] for values in (theta, phi, d, alpha)), strict=True))


def meet(theta, phi, d, *, alpha):
    """(R, H), (2, n), and flags (n,)."""
    directions = book.side_ray(theta, phi, alpha)
    origins = np.stack([d, 0 * d, 0 * d], axis=-1)
    meetings = Sheet().meet(origins, directions)
    points = origins + meetings.distance[0][:, None] * directions
    return points.T[1:], meetings.flags[0]


def test_radius_and_height_are_those_of_the_closed_form():
    case = cases()
    found, flags = meet(**case)
    np.testing.assert_allclose(found, book.side_radius(**case), rtol=1e-12, atol=1e-13)
    assert (flags & MeetingFlag.BEHIND == 0).all()
    assert found.shape[1] > 300


def test_slopes_are_the_printed_partial_derivatives():
    """Eq. 5-26 to 5-33, all eight right as printed."""
    case = cases()
    stepped = [meet(**{**case, name: case[name] + 1j * STEP})[0].imag / STEP for name in NAMES]
    np.testing.assert_allclose(np.swapaxes(stepped, 0, 1), book.side_slopes(**case), rtol=1e-9, atol=1e-11)


def test_on_the_centre_row_the_radius_is_baseline_times_cotangent():
    """Equation book: R = D cot(alpha - theta)."""
    case = {**cases(), "phi": np.pi / 2}
    kept = case["alpha"] - case["theta"] > 0.02
    case = {name: np.broadcast_to(values, kept.shape)[kept] for name, values in case.items()}
    found, _ = meet(**case)
    np.testing.assert_allclose(found[0], case["d"] / np.tan(case["alpha"] - case["theta"]), rtol=1e-12)
    np.testing.assert_allclose(found[1], 0, atol=1e-12)


def test_rays_that_turn_away_from_the_sheet_are_behind():
    case = cases()
    _, flags = meet(**{**case, "phi": np.full_like(case["phi"], np.pi / 2), "theta": case["alpha"] + 0.1})
    assert (flags & MeetingFlag.BEHIND != 0).all()

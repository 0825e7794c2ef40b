"""A real laser line in a weld groove, with spatter and a gap."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from calibore.stripe import Stripe, detect_line

WELD = Path(__file__).parents[2].parent / "shared" / "data" / "real" / "weld-laser-line" / "weld2.png"
SEGMENTS = [
    (20, 500, 389.39, -0.00839),
    (530, 730, -87.98, 0.9115),
    (850, 1030, 1290.02, -0.8651),
    (1060, 1270, 367.09, 0.02546),
]
"""First and last column, intercept and slope [px] of the straight parts, as printed in the README of the data."""
GAP = slice(745, 806)


@pytest.fixture(scope="module")
def stripe() -> Stripe:
    if not WELD.exists():
        pytest.skip(f"no shared data at {WELD}")
    return detect_line(cv2.imread(str(WELD), cv2.IMREAD_GRAYSCALE))


@pytest.mark.parametrize(("first", "last", "intercept", "slope"), SEGMENTS)
def test_the_straight_parts_are_found_within_a_pixel(
    stripe: Stripe, first: int, last: int, intercept: float, slope: float
) -> None:
    column, row = stripe.u[first : last + 1], stripe.v[first : last + 1]
    good = np.isfinite(row)
    fitted = np.polyfit(column[good], row[good], 1)
    ends = np.array([first, last])
    np.testing.assert_allclose(np.polyval(fitted, ends), intercept + slope * ends, atol=1.0)
    assert good.mean() > 0.95
    assert np.mean(np.abs(row[good] - intercept - slope * column[good]) < 5) > 0.9, "spatter is rejected"


def test_the_gap_is_not_filled(stripe: Stripe) -> None:
    assert stripe.found[GAP].mean() <= 0.1

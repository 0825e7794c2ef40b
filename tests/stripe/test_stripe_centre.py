"""Where the ring's centre is."""

import numpy as np
import pytest
from stripe_scenes import red, ring_brightness

from calibore.errors import InputError
from calibore.stripe import area_centroid, detect_ring


def test_the_area_centroid_of_polygons_is_exact() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        count = int(rng.integers(3, 40))
        azimuth = np.sort(rng.uniform(0, 2 * np.pi, count))
        if np.max(np.diff(np.append(azimuth, azimuth[0] + 2 * np.pi))) > 3:
            continue
        x, y = rng.uniform(100, 200, count) * np.array([np.cos(azimuth), np.sin(azimuth)]) + rng.normal(0, 500, (2, 1))
        # fan of triangles from the first corner, each with its own centroid
        cross = 0.5 * ((x[1:-1] - x[0]) * (y[2:] - y[0]) - (x[2:] - x[0]) * (y[1:-1] - y[0]))
        expected = [np.sum(cross * (a[0] + a[1:-1] + a[2:]) / 3) / cross.sum() for a in (x, y)]
        start = int(rng.integers(count))
        np.testing.assert_allclose(area_centroid(x, y), expected, rtol=0, atol=1e-9)
        np.testing.assert_allclose(area_centroid(x[::-1], y[::-1]), expected, rtol=0, atol=1e-9)
        np.testing.assert_allclose(area_centroid(np.roll(x, start), np.roll(y, start)), expected, rtol=0, atol=1e-9)


def test_points_without_area_have_no_centroid() -> None:
    with pytest.raises(InputError, match="no area"):
        area_centroid(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 2.0]))
    with pytest.raises(InputError, match="at least 3"):
        area_centroid(np.array([0.0, 1.0]), np.array([0.0, 1.0]))


@pytest.mark.parametrize("azimuth", np.deg2rad([0, 77, 180, 300]))
def test_re_centring_converges_from_40_px_off(azimuth: float) -> None:
    truth = (163.4, 151.7)
    image = red(180 * ring_brightness((300, 330), truth, 80.0), np.random.default_rng(0))
    start = (truth[0] + 40 * np.cos(azimuth), truth[1] + 40 * np.sin(azimuth))
    stripe = detect_ring(image, start, inner=20, outer=140, channel="red", rays=600)
    assert stripe.centre is not None
    assert np.hypot(stripe.centre[0] - truth[0], stripe.centre[1] - truth[1]) < 0.5
    radius = np.hypot(stripe.u - truth[0], stripe.v - truth[1])
    assert stripe.found.mean() > 0.99
    assert np.nanstd(radius) < 0.05


def test_sectors_keep_a_feature_from_moving_the_centre() -> None:
    truth, shape = (163.4, 151.7), (300, 330)
    row, column = np.indices(shape)
    azimuth = np.arctan2(row - truth[1], column - truth[0])
    bulge = 18 * np.exp(-((azimuth - 0.6) ** 2) / (2 * 0.2**2))
    distance = np.hypot(column - truth[0], row - truth[1]) - 80 - bulge
    image = red(180 * np.exp(-(distance**2) / (2 * 1.6**2)), np.random.default_rng(1))

    def off(stripe_sectors: list[tuple[float, float]] | None) -> float:
        stripe = detect_ring(image, (160, 150), inner=40, outer=130, channel="red", sectors=stripe_sectors)
        assert stripe.centre is not None
        return float(np.hypot(stripe.centre[0] - truth[0], stripe.centre[1] - truth[1]))

    # arcs closed by chords: only opposite sectors have their area centroid at the centre of the circle
    opposite = [(1.3, 3.4), (1.3 + np.pi, 3.4 + np.pi)]
    assert off(None) > 2.0
    assert off(opposite) < 1.0  # it rests when it moves less than 0.5 px, and chords make it move slowly


@pytest.mark.parametrize("kernel", ["native", "scalar", "numpy"])
@pytest.mark.parametrize("degrees", [60, 120, 150, 200, 300])
def test_an_arc_is_measured_as_far_as_it_is_there(degrees: float, kernel: str) -> None:
    truth, shape = (163.4, 151.7), (300, 330)
    row, column = np.indices(shape)
    azimuth = np.mod(np.arctan2(row - truth[1], column - truth[0]), 2 * np.pi)
    arc = ring_brightness(shape, truth, 80.0) * (azimuth < np.deg2rad(degrees))
    image = red(180 * arc, np.random.default_rng(4))
    stripe = detect_ring(image, (160, 150), inner=40, outer=130, channel="red", rays=600, kernel=kernel)
    assert stripe.centre is not None
    turned = np.mod(np.arctan2(stripe.v - truth[1], stripe.u - truth[0]) + 0.1, 2 * np.pi)
    seen = np.sort(turned[stripe.found])
    # its whole length, with no hole, whatever the chord between its ends does to a centroid
    assert np.degrees(seen[-1] - seen[0]) > degrees - 3
    assert np.degrees(np.diff(seen).max()) < 3
    assert np.nanstd(np.hypot(stripe.u - truth[0], stripe.v - truth[1])) < 0.1

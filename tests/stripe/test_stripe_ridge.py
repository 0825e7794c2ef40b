"""Steger's line detector, for comparison: an estimator that sees the neighbouring rays too."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from stripe_scenes import line_image, red, ring_brightness, speckled_line

from calibore.status import Status
from calibore.stripe import detect_line, detect_ring


@pytest.mark.parametrize("seed", range(6))
def test_its_uncertainty_covers_the_true_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    width = rng.uniform(1.3, 3.0)
    if seed % 2:
        image, row = speckled_line(rng, rng.uniform(0.1, 0.4), width=width, blur=0.6 * width)
    else:
        image, row = line_image(rng, width=width, slope=rng.uniform(0.01, 0.03))
    stripe = detect_line(image, estimator="steger")
    z = ((stripe.v - row) / stripe.u_position)[stripe.found]
    assert 0.85 < np.sqrt(np.mean(z**2)) < 1.15  # 300 to 1000 independent places: 2 to 4 %; the line is no Gaussian
    assert 0.92 < np.mean(np.abs(z) < 1.96) < 0.98


def test_its_places_lie_on_the_lines_that_whole_convolutions_find() -> None:
    centre = (140.4, 131.7)
    image = red(150 * ring_brightness((270, 280), centre, 96.0, width=2.0), np.random.default_rng(1))
    stripe = detect_ring(image, (141, 131), inner=60, outer=125, channel="red", rays=600, estimator="steger")
    assert stripe.found.all()
    off = np.abs(off_the_line(image[:, :, 0].astype(float), stripe.noise.width, stripe.u, stripe.v))
    assert np.quantile(off, 0.9) < 1e-9
    assert off.max() < 0.05  # where the ray leaves the pixel that saw the line


def off_the_line(picture: np.ndarray, sigma: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """How far (n,) [px] places u, v (n,) are from Steger's line as the pixels see it on which they lie."""

    def by(order: tuple[int, int]) -> np.ndarray:
        whole = gaussian_filter(picture, sigma, order=order, radius=int(np.ceil(4 * sigma)))
        return whole[np.rint(v).astype(int), np.rint(u).astype(int)]

    hessian = np.stack([by((0, 2)), by((1, 1)), by((1, 1)), by((2, 0))], axis=1).reshape(-1, 2, 2)
    bend, vectors = np.linalg.eigh(hessian)
    across = vectors[:, :, 0]
    t = -np.sum(np.stack([by((0, 1)), by((1, 0))], axis=1) * across, axis=1) / bend[:, 0]
    return np.sum(np.stack([u - np.rint(u), v - np.rint(v)], axis=1) * across, axis=1) - t


def test_it_measures_nothing_where_its_smoothing_would_leave_the_picture() -> None:
    image, _ = line_image(np.random.default_rng(2), columns=400, width=2.0)
    stripe = detect_line(image, estimator="steger")
    edge = np.r_[:8, 392:400]  # four times the width
    assert np.all(stripe.status[edge] == Status.NO_PEAK)
    assert np.all(np.isnan(stripe.v[edge]) & np.isnan(stripe.height[edge]) & np.isnan(stripe.u_position[edge]))
    assert stripe.found[12:388].all()


def test_a_bent_line_is_drawn_inwards_as_its_smoothing_draws_it() -> None:
    centre, radius, width = (140.4, 131.7), 60.0, 2.0
    image = np.rint(8 + 200 * ring_brightness((270, 280), centre, radius, width=width)).astype(np.uint8)
    inward = {}
    for name in ("zero-crossing", "steger"):
        stripe = detect_ring(image, (140, 132), inner=30, outer=100, rays=400, estimator=name)
        inward[name] = radius - np.mean(np.hypot(stripe.u - centre[0], stripe.v - centre[1]))
    assert abs(inward["zero-crossing"]) < 0.003
    # the ring's brightness convolved with a Gaussian of the same sigma s, along the ring: s^2 / 2 R to first order
    assert 0.95 < inward["steger"] / (width**2 / (2 * radius)) < 1.25  # the width learnt is a little large

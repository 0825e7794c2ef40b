"""Lines that run down a picture, as a side-facing head sees them: one peak per row."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stripe_scenes import line_image, speckled_line

from calibore.images import read_image
from calibore.stripe import Stripe, detect_line
from calibore.stripe._kernel import KERNELS

SIDE = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "side-2.4in"
ESTIMATORS = ("zero-crossing", "parabola", "maximum", "threshold", "centroid", "correlation")


def assert_transposed(down: Stripe, across: Stripe) -> None:
    """Every number the same, rows and columns exchanged."""
    np.testing.assert_array_equal(down.u, across.v)
    np.testing.assert_array_equal(down.v, across.u)
    np.testing.assert_array_equal(down.direction, across.direction[:, ::-1])
    for name in ("u_position", "status", "height", "correlation"):
        np.testing.assert_array_equal(getattr(down, name), getattr(across, name))
    assert (down.noise, down.scale) == (across.noise, across.scale)


def colours(image: np.ndarray) -> np.ndarray:
    return np.stack([image, image // 5, image // 7], axis=2)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_line_down_the_picture_is_that_across_the_transposed_one(kernel: str, estimator: str) -> None:
    image, _ = speckled_line(np.random.default_rng(2), 0.4, columns=300)
    options: dict[str, Any] = {"kernel": kernel, "estimator": estimator}
    assert_transposed(detect_line(image.T, down=True, **options), detect_line(image, **options))


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("channel", ["red", "luma"])
@pytest.mark.parametrize("gain", [1, 257])
def test_so_it_is_in_colour_and_in_16_bits(kernel: str, channel: str, gain: int) -> None:
    grey, _ = line_image(np.random.default_rng(3), columns=250)
    image = colours(grey) if gain == 1 else colours(grey).astype(np.uint16) * np.uint16(gain)
    options: dict[str, Any] = {"kernel": kernel, "channel": channel}
    assert_transposed(detect_line(image.swapaxes(0, 1), down=True, **options), detect_line(image, **options))


@pytest.mark.parametrize("seed", range(3))
def test_each_row_has_one_peak_where_the_line_is(seed: int) -> None:
    image, place = line_image(np.random.default_rng(seed), columns=600)
    stripe = detect_line(image.T, down=True)
    assert stripe.found.all()
    np.testing.assert_array_equal(stripe.v, np.arange(600))
    z = (stripe.u - place) / stripe.u_position
    assert 0.9 < np.sqrt(np.mean(z**2)) < 1.1  # 600 peaks: 3 % of scatter


def test_rows_without_the_line_have_no_number() -> None:
    image, _ = line_image(np.random.default_rng(5), columns=600)
    image[:, 200:300] = 8
    stripe = detect_line(image.T, down=True)
    assert not stripe.found[205:295].any()
    assert stripe.found[:195].all()
    assert stripe.found[305:].all()


@pytest.mark.skipif(not SIDE.exists(), reason="needs the shared side-facing survey")
@pytest.mark.parametrize("stop", [0, 25, 300])
def test_both_kernels_see_the_same_rows_of_a_survey(stop: int) -> None:
    image = read_image(SIDE / f"side 000 {stop:03d} 0.png")[:400]
    native, twin = (detect_line(image, down=True, channel="red", kernel=kernel) for kernel in ("native", "numpy"))
    np.testing.assert_array_equal(native.status, twin.status)
    np.testing.assert_allclose(native.u, twin.u, atol=1e-3, rtol=0)  # a thousandth of u; speckle enlarges rounding
    np.testing.assert_allclose(native.u_position, twin.u_position, rtol=1e-3)
    assert native.noise.additive == pytest.approx(twin.noise.additive, rel=1e-6)


@pytest.mark.skipif(not SIDE.exists(), reason="needs the shared side-facing survey")
def test_u_holds_where_speckle_is_coarser_than_the_line_is_smooth() -> None:
    """There a fit that trusts its model leaves many peaks, and the scatter of the others says too little."""
    truth = np.load(SIDE / "truth.npz")
    scores = []
    for number, stop in enumerate(range(0, 400, 25)):
        stripe = detect_line(read_image(SIDE / f"side 000 {stop:03d} 0.png"), down=True, channel="red")
        seen = truth["row_visible"][0, number] & (truth["row_signal"][0, number] > 0.05)
        seen &= (truth["row_count"][0, number] == 1) & stripe.found
        z = ((stripe.u - truth["row_u"][0, number]) / stripe.u_position)[seen]
        scores.append(np.sqrt(np.mean(z**2)))
    assert 0.9 < np.sqrt(np.mean(np.square(scores))) < 1.1
    assert max(scores) < 1.4

"""Whatever comes in, what comes out is a Stripe or one of Calibore's own errors."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stripe_scenes import red, ring_brightness

from calibore.errors import CaliboreError, ImageError, InputError, UsageError
from calibore.status import Status
from calibore.stripe import Stripe, detect_line, detect_ring

RING = red(160 * ring_brightness((120, 130), (64.0, 60.0), 40.0), np.random.default_rng(0))
KERNELS = ["native", "numpy"]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize(
    ("change", "error", "sentence"),
    [
        ({"centre": (np.nan, 60)}, InputError, "centre"),
        ({"centre": (np.inf, 60)}, InputError, "centre"),
        ({"inner": 50, "outer": 30}, InputError, "inner"),
        ({"inner": -1}, InputError, "inner"),
        ({"outer": np.nan}, InputError, "outer"),
        ({"outer": 1e9}, InputError, "outer"),
        ({"rays": 3}, InputError, "rays"),
        ({"rays": 1 << 40}, InputError, "rays"),
        ({"channel": "infrared"}, UsageError, "infrared"),
        ({"estimator": "best"}, UsageError, "best"),
        ({"sectors": [(0.0, np.nan)]}, InputError, "sector"),
        ({"centre": (5000, 60)}, ImageError, "outside"),
        ({"image": RING[:, :, :2]}, ImageError, "bands"),
        ({"image": RING.astype(float)}, ImageError, "float64"),
        ({"image": RING[:0]}, ImageError, "at least"),
        ({"image": np.zeros((7, 500), np.uint8)}, ImageError, "500 x 7"),
        ({"image": np.zeros_like(RING)}, ImageError, "no laser ring"),
        ({"image": np.full_like(RING, 255)}, ImageError, "no laser ring"),
    ],
)
def test_a_bad_call_is_told_what_is_wrong(kernel: str, change: dict, error: type, sentence: str) -> None:
    arguments: dict[str, Any] = {"image": RING, "centre": (63, 61), "inner": 15, "outer": 58, "channel": "red"}
    arguments |= {"rays": 200} | change
    with pytest.raises(error, match=sentence):
        detect_ring(arguments.pop("image"), arguments.pop("centre"), kernel=kernel, **arguments)


def test_an_unknown_kernel_is_refused() -> None:
    with pytest.raises(UsageError, match="Kernel"):
        detect_ring(RING, (63, 61), inner=15, outer=58, kernel="fortran")


def test_no_line_is_no_error_but_no_value_either() -> None:
    stripe = detect_line(np.zeros((40, 60), np.uint8))
    assert np.all(stripe.status == Status.NO_PEAK)
    assert np.isnan(stripe.v).all()


@st.composite
def calls(draw: st.DrawFn) -> dict[str, Any]:
    """A random small image, with or without a ring, and a random search region."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    height, width = draw(st.integers(8, 90)), draw(st.integers(8, 90))
    centre = (draw(st.floats(-20, 110)), draw(st.floats(-20, 110)))
    ring = ring_brightness((height, width), centre, draw(st.floats(0, 60)), width=draw(st.floats(0.3, 15)))
    image = red(draw(st.floats(0, 2000)) * ring, rng)
    kind = draw(st.sampled_from(["colour", "grey", "16 bit", "noise", "flat"]))
    if kind == "grey":
        image = image[:, :, 0]
    elif kind == "16 bit":
        image = image.astype(np.uint16) * draw(st.integers(1, 257))
    elif kind == "noise":
        image = rng.integers(0, draw(st.integers(1, 256)), image.shape, dtype=np.uint8)
    elif kind == "flat":
        image = np.full_like(image, draw(st.integers(0, 255)))
    inner = draw(st.floats(0, 60))
    return {
        "image": image,
        "centre": (centre[0] + draw(st.floats(-30, 30)), centre[1] + draw(st.floats(-30, 30))),
        "inner": inner,
        "outer": inner + draw(st.floats(0.01, 80)),
        "rays": draw(st.integers(16, 200)),
        "channel": draw(st.sampled_from(["red", "green", "blue", "luma"])),
        "estimator": draw(
            st.sampled_from(["zero-crossing", "parabola", "maximum", "threshold", "centroid", "correlation", "steger"])
        ),
    }


def assert_sound(stripe: Stripe) -> None:
    for values in (stripe.u, stripe.v, stripe.u_position, stripe.height):
        assert np.all(np.isfinite(values) == stripe.found)
    assert np.all(stripe.u_position[stripe.found] > 0)
    assert set(stripe.status) <= {0, 1, 2, 3, 4, 5, 6}


@settings(max_examples=150, deadline=None)
@given(calls())
def test_any_image_gives_a_stripe_or_an_error_of_ours(call: dict[str, Any]) -> None:
    results = []
    for kernel in KERNELS:
        try:
            stripe = detect_ring(call["image"], kernel=kernel, **{k: v for k, v in call.items() if k != "image"})
            assert_sound(stripe)
            results.append(stripe.status.tolist())
        except CaliboreError as error:
            results.append(str(error))
    assert results[0] == results[1]


@settings(max_examples=60, deadline=None)
@given(calls())
def test_any_image_gives_a_line_or_none(call: dict[str, Any]) -> None:
    options = {"channel": call["channel"], "estimator": call["estimator"]}
    one, other = (detect_line(call["image"], kernel=kernel, **options) for kernel in KERNELS)
    assert_sound(one)
    np.testing.assert_array_equal(one.status, other.status)

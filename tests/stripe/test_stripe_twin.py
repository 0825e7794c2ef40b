"""The compiled kernel, with the vector instructions of the machine or without, and its NumPy twin say the same."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from stripe_scenes import line_image, red, ring_brightness

from calibore.errors import ImageError
from calibore.images import read_image
from calibore.stripe import Stripe, detect_line, detect_ring, estimator_named
from calibore.stripe._features import freed_of_features
from calibore.stripe._picture import prepare
from calibore.stripe._twin import Annulus, line_numpy, ring_numpy

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
SIDE = SIMULATED / "side-2.4in"
FOLDERS = ["plane-3in", "plane-6in", "plane-12in", "plane-30in", "plane-misaligned", "field", "epochs/A"]
NAMES = ("zero-crossing", "parabola", "maximum", "threshold", "centroid", "correlation", "steger")
SHAPE, CENTRE = (190, 210), (106.3, 93.8)


def outcome(image: np.ndarray, **options: Any) -> Stripe | str:
    arguments: dict = {"inner": 25, "outer": 92, "channel": "red", "rays": 300} | options
    try:
        return detect_ring(image, arguments.pop("centre", (104.0, 95.0)), **arguments)
    except ImageError as error:
        return str(error)


def assert_same(one: Stripe | str, other: Stripe | str) -> None:
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
        return
    np.testing.assert_array_equal(one.status, other.status)
    np.testing.assert_allclose([one.u, one.v], [other.u, other.v], atol=1e-4, rtol=0)
    np.testing.assert_allclose(one.u_position, other.u_position, rtol=1e-3)
    np.testing.assert_allclose(one.height, other.height, rtol=1e-6)
    np.testing.assert_allclose(one.correlation, other.correlation, atol=1e-6)
    assert one.confidence is not None
    assert other.confidence is not None
    np.testing.assert_allclose(one.confidence, other.confidence, atol=1e-9)
    for field in ("additive", "gain", "contrast", "width", "grain"):
        assert getattr(one.noise, field) == pytest.approx(getattr(other.noise, field), rel=1e-6)
    assert one.scale == pytest.approx(other.scale, rel=1e-6)
    assert one.centre == pytest.approx(other.centre, abs=1e-6)


def assert_identical(one: Stripe | str, other: Stripe | str) -> None:
    """To the last bit: nothing is added in another order."""
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
        return
    for name in ("status", "u", "v", "u_position", "height", "correlation", "confidence"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.noise, one.scale, one.centre) == (other.noise, other.scale, other.centre)


def scene(kind: str) -> tuple[np.ndarray, dict]:
    rng = np.random.default_rng(3)
    ring = ring_brightness(SHAPE, CENTRE, 60.0)
    image = red((700 if kind == "saturated" else 22 if kind == "faint" else 160) * ring, rng)
    speckled = red(160 * ring * rng.gamma(3, 1 / 3, SHAPE), rng)
    options: dict[str, tuple[np.ndarray, dict]] = {
        "saturated": (image, {}),
        "faint": (image, {}),
        "speckled": (speckled, {}),
        "no ring": (red(np.zeros(SHAPE), rng), {}),
        "black": (np.zeros((*SHAPE, 3), np.uint8), {}),
        "noise": (rng.integers(0, 256, (*SHAPE, 3), dtype=np.uint8), {}),
        "partly outside": (speckled[40:, :150].copy(), {"centre": (104.0, 55.0)}),
        "far outside": (image, {"centre": (1e5, -3e4)}),
        "16 bit": (image.astype(np.uint16) * 257, {}),
        "grey": (image[:, :, 0].copy(), {}),
        "luma": (image, {"channel": "luma"}),
        "16 bit luma": (image.astype(np.uint16) * 200, {"channel": "luma"}),
        "not contiguous": (image[:, :, ::-1], {"channel": "blue"}),
        "odd rays": (speckled, {"rays": 307}),
        "off centre": (speckled, {"centre": (118.0, 84.0)}),
        "sectors": (speckled, {"sectors": [(0.0, 2.0), (3.0, 5.0)]}),
    }
    return options[kind]


KINDS = [
    "saturated",
    "faint",
    "speckled",
    "no ring",
    "black",
    "noise",
    "partly outside",
    "far outside",
    "16 bit",
    "grey",
]
KINDS += ["luma", "16 bit luma", "not contiguous", "odd rays", "off centre", "sectors"]


@pytest.mark.parametrize("kind", KINDS)
def test_all_kernels_see_the_same_ring(kind: str) -> None:
    image, options = scene(kind)
    one, scalar, twin = (outcome(image, kernel=kernel, **options) for kernel in ("native", "scalar", "numpy"))
    assert_same(one, twin)
    assert_identical(one, scalar)


@pytest.mark.parametrize("name", NAMES)
def test_all_kernels_agree_for_every_estimator(name: str) -> None:
    image, _ = scene("speckled")
    one, scalar, twin = (outcome(image, kernel=kernel, estimator=name) for kernel in ("native", "scalar", "numpy"))
    assert isinstance(one, Stripe)
    assert_same(one, twin)
    assert_identical(one, scalar)
    line, _ = line_image(np.random.default_rng(1), columns=160, slope=0.11)
    one, scalar, twin = (detect_line(line, kernel=kernel, estimator=name) for kernel in ("native", "scalar", "numpy"))
    assert_same(one, twin)
    assert_identical(one, scalar)


@pytest.mark.parametrize("down", [True, False])
@pytest.mark.parametrize("width", range(88, 108))
def test_vector_instructions_change_no_byte_of_pictures_of_any_width(width: int, down: bool) -> None:
    rng = np.random.default_rng(width)
    grey, _ = line_image(rng, columns=140)
    grey = np.pad(grey, ((width - len(grey), 0), (0, 0)), mode="edge")
    picture = grey.T if down else grey
    for image in (picture, red(picture.astype(float), rng), picture.astype(np.uint16) * np.uint16(257)):
        options: dict[str, Any] = {"down": down, "channel": "red" if image.ndim == 3 else "luma"}
        one, scalar, twin = (detect_line(image, kernel=kernel, **options) for kernel in ("native", "scalar", "numpy"))
        assert_identical(one, scalar)
        np.testing.assert_array_equal(one.status, twin.status)


def shared(folder: str) -> tuple[np.ndarray, tuple[float, float], float]:
    paths = sorted(p for p in (SIMULATED / folder).glob("*") if p.suffix in (".png", ".jpg"))
    if not paths:
        pytest.skip(f"no shared images at {SIMULATED / folder}")
    image = cv2.imread(str(paths[len(paths) // 2]))[:, :, ::-1].copy()
    height, width = image.shape[:2]
    return image, (width / 2, height / 2), height / 2 - 4


@pytest.mark.parametrize("folder", FOLDERS)
def test_all_kernels_agree_on_the_shared_images(folder: str) -> None:
    image, centre, outer = shared(folder)
    options: dict = {"centre": centre, "inner": 80.0, "outer": outer, "rays": 1000}
    one, scalar, twin = (outcome(image, kernel=kernel, **options) for kernel in ("native", "scalar", "numpy"))
    assert_same(one, twin)
    assert_identical(one, scalar)


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_compiled_kernel_has_freed_the_line_of_features_as_the_twin_would(folder: str) -> None:
    image, centre, outer = shared(folder)
    stripe = outcome(image, centre=centre, inner=80.0, outer=outer, rays=1500)
    assert isinstance(stripe, Stripe)
    again = freed_of_features(stripe)  # what is free of features stays what it is
    np.testing.assert_allclose(again.u_position, stripe.u_position, rtol=1e-9)
    np.testing.assert_allclose(again.correlation, stripe.correlation, atol=1e-9)


@pytest.mark.skipif(not SIDE.exists(), reason="needs the shared side-facing survey")
@pytest.mark.parametrize("stop", [0, 150, 300])
def test_vector_instructions_change_no_byte_of_a_side_facing_picture(stop: int) -> None:
    image = read_image(SIDE / f"side 000 {stop:03d} 0.png")
    one, scalar = (detect_line(image, down=True, channel="red", kernel=kernel) for kernel in ("native", "scalar"))
    assert_identical(one, scalar)
    np.testing.assert_allclose(freed_of_features(one).u_position, one.u_position, rtol=1e-9)


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_guided_scan_finds_what_a_full_one_finds(folder: str) -> None:
    image, centre, outer = shared(folder)
    ring = Annulus(centre, 80.0, outer, 1000, np.ones(1000, dtype=bool))
    full = ring_numpy(prepare(image, "red"), ring, estimator_named("zero-crossing"), guided=False)
    found = outcome(image, centre=centre, inner=80.0, outer=outer, rays=1000)
    assert isinstance(found, Stripe)
    np.testing.assert_array_equal(found.found, full.found)
    np.testing.assert_allclose([found.u, found.v], [full.u, full.v], atol=1e-9)
    assert np.mean(found.status != full.status) <= 0.005, "specks between coarse rays may go unseen"


@pytest.mark.skipif(not SIDE.exists(), reason="needs the shared side-facing survey")
@pytest.mark.parametrize("stop", [0, 300])
def test_the_guided_scan_of_a_line_finds_what_a_full_one_finds(stop: int) -> None:
    image = read_image(SIDE / f"side 000 {stop:03d} 0.png")
    full = line_numpy(prepare(image, "red"), estimator_named("zero-crossing"), down=True, guided=False)
    found = detect_line(image, down=True, channel="red")
    np.testing.assert_array_equal(found.found, full.found)
    np.testing.assert_allclose([found.u, found.v], [full.u, full.v], atol=1e-4)
    assert np.mean(found.status != full.status) <= 0.005, "specks between coarse rays may go unseen"


@pytest.mark.parametrize("seed", range(4))
def test_a_line_that_leaps_and_is_torn_between_coarse_rays_is_found_by_the_guided_scan(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = 60.0 + 0.05 * np.arange(1200) + 25.0 * (np.arange(1200) >= rng.integers(300, 900))
    row = np.arange(180)[:, None]
    light = 8 + 150 * np.exp(-((row - place) ** 2) / 8) * (rng.uniform(size=1200) > 0.1)
    light[20:23, rng.integers(0, 1200, 40)] += 200  # specks
    image = np.clip(np.rint(light + rng.normal(size=light.shape)), 0, 255).astype(np.uint8)
    full = line_numpy(prepare(image, "luma"), estimator_named("zero-crossing"), down=False, guided=False)
    found = detect_line(image)
    np.testing.assert_array_equal(found.found, full.found)
    np.testing.assert_allclose(found.v, full.v, atol=1e-4)

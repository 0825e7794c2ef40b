"""From a file to its lines in one call: to the last bit what reading the picture and then measuring it gives."""

from dataclasses import fields, replace
from pathlib import Path
from threading import Thread

import cv2
import numpy as np
import pytest
from PIL import Image

from calibore.images import read_image
from calibore.stripe import RingPlace, Stripe, detect_line, detect_line_in, detect_ring, detect_rings_in

SIZE = (320, 240)
PLACE = RingPlace((155.0, 118.0), 40.0, 110.0, "red")
LIMIT = 1_000_000
FORMATS = [".png", ".tif", ".ppm", ".bmp", ".jpg"]


def picture(seed: int, *, white: int = 255, colour: bool = True) -> np.ndarray:
    """A red ring of about 80 px, a little green light, noise in all colours; (240, 320, 3) or its red plane."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[: SIZE[1], : SIZE[0]]
    distance = np.hypot(u - 158 - rng.normal(), v - 121) - 80 - 4 * np.sin(np.arctan2(v - 121, u - 158) * 3)
    levels = np.stack(
        [170 * np.exp(-0.5 * (distance / 1.8) ** 2), 9 * np.exp(-0.5 * (distance / 9) ** 2), 0 * u], axis=-1
    )
    pixels = (levels + 12 + rng.normal(0, 3, levels.shape)).clip(0, 255) / 255 * white
    pixels = np.round(pixels).astype(np.uint8 if white == 255 else np.uint16)
    return pixels if colour else np.ascontiguousarray(pixels[..., 0])


def written(folder: Path, name: str, pixels: np.ndarray) -> Path:
    path = folder / name
    bgr = pixels[..., ::-1] if pixels.ndim == 3 else pixels
    assert cv2.imwrite(str(path), np.ascontiguousarray(bgr), [cv2.IMWRITE_TIFF_COMPRESSION, 1])
    return path


def assert_identical(one: Stripe, other: Stripe) -> None:
    for field in fields(Stripe):
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b


def two_steps(path: Path, place: RingPlace) -> Stripe:
    return detect_ring(read_image(path), place.centre, inner=place.inner, outer=place.outer, channel=place.channel)


@pytest.mark.parametrize("extension", FORMATS)
@pytest.mark.parametrize("channel", ["red", "luma"])
def test_one_call_finds_the_ring_of_two_steps_to_the_last_bit(extension: str, channel: str, tmp_path: Path) -> None:
    place = replace(PLACE, channel=channel)
    for seed, colour in [(1, True), (2, False), (3, True)]:  # each in the memory that the one before has left
        name = "a.pgm" if extension == ".ppm" and not colour else f"a{extension}"
        path = written(tmp_path, name, picture(seed, colour=colour))
        found = detect_rings_in(path, [place, place], size=SIZE, limit=LIMIT)
        assert found is not None
        for stripe in found:
            assert stripe.found.mean() > 0.95
            assert_identical(stripe, two_steps(path, place))


@pytest.mark.parametrize("extension", [".png", ".tif", ".ppm"])
def test_one_call_finds_the_ring_in_sixteen_bits_after_one_of_eight(extension: str, tmp_path: Path) -> None:
    for white in (255, 65535, 255):
        path = written(tmp_path, f"a{extension}", picture(4, white=white))
        found = detect_rings_in(path, [PLACE], size=SIZE, limit=LIMIT)
        assert found is not None
        assert_identical(found[0], two_steps(path, PLACE))


@pytest.mark.parametrize("down", [False, True])
def test_one_call_finds_the_line_of_two_steps_to_the_last_bit(down: bool, tmp_path: Path) -> None:
    v, u = np.mgrid[: SIZE[1], : SIZE[0]]
    across = u - 150 if down else v - 110
    rng = np.random.default_rng(5)
    pixels = (
        (150 * np.exp(-0.5 * (across / 2.0) ** 2) + 15 + rng.normal(0, 3, across.shape)).clip(0, 255).astype(np.uint8)
    )
    path = written(tmp_path, "a.png", pixels)
    found = detect_line_in(path, size=SIZE, limit=LIMIT, down=down)
    assert found is not None
    assert_identical(found, detect_line(pixels, down=down))


@pytest.mark.parametrize("options", [{}, {"progressive": True}, {"restart_marker_blocks": 3}], ids=str)
@pytest.mark.parametrize("subsampling", [0, 1, 2])
@pytest.mark.parametrize("size", [(61, 43), (320, 240)])
def test_nothing_of_an_earlier_picture_shines_through_a_jpeg(
    options: dict, subsampling: int, size: tuple[int, int], tmp_path: Path
) -> None:
    for colour in (True, False):
        path = tmp_path / "a.jpg"
        pixels = picture(7, colour=colour)[: size[1], : size[0]]
        Image.fromarray(pixels).save(path, quality=85, subsampling=subsampling, **options)
        decoded = []
        for level in (0, 255):
            left = written(tmp_path, "left.png", np.full_like(picture(7), level))
            assert detect_rings_in(left, [PLACE], size=SIZE, limit=LIMIT) is None
            decoded.append(read_image(path))
        np.testing.assert_array_equal(*decoded)


def test_nothing_is_found_where_two_steps_raise(tmp_path: Path) -> None:
    whole = written(tmp_path, "whole.png", picture(6))
    (tmp_path / "cut.png").write_bytes(whole.read_bytes()[:-2000])
    (tmp_path / "empty.png").write_bytes(b"")
    dark = written(tmp_path, "dark.png", np.zeros_like(picture(6)))
    beside = replace(PLACE, centre=(900.0, 900.0), inner=20.0, outer=40.0)
    assert detect_rings_in(whole, [PLACE], size=SIZE, limit=LIMIT) is not None
    assert detect_rings_in(whole, [PLACE], size=(320, 241), limit=LIMIT) is None
    assert detect_rings_in(whole, [PLACE], size=SIZE, limit=1000) is None
    assert detect_rings_in(whole, [PLACE, beside], size=SIZE, limit=LIMIT) is None
    for path in (dark, tmp_path, tmp_path / "cut.png", tmp_path / "empty.png", tmp_path / "absent.png"):
        assert detect_rings_in(path, [PLACE], size=SIZE, limit=LIMIT) is None
        assert detect_line_in(path, size=(2, 2), limit=LIMIT) is None


def test_threads_find_the_same_rings_as_one_after_the_other(tmp_path: Path) -> None:
    sizes = [SIZE, SIZE, SIZE]
    paths = [written(tmp_path, f"{seed}.png", picture(seed)) for seed in range(len(sizes))]
    found: dict[int, list[Stripe | None]] = {}

    def every(number: int) -> None:
        calls = [detect_rings_in(path, [PLACE], size=SIZE, limit=LIMIT) for path in 4 * paths]
        found[number] = [call[0] if call else None for call in calls]

    threads = [Thread(target=every, args=(number,)) for number in range(3)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    expected = 4 * [two_steps(path, PLACE) for path in paths]
    for stripes in found.values():
        for stripe, wanted in zip(stripes, expected, strict=True):
            assert stripe is not None
            assert_identical(stripe, wanted)

"""The short ways of the decoder for simple PNG and TIFF files against the decoders for every kind, and PGM and PPM."""

import io
import struct
import zlib
from itertools import pairwise

import cv2
import numpy as np
import pytest
from calibore._native import decode_image, image_size
from PIL import Image

KINDS = {0: 1, 2: 3, 4: 2, 6: 4}
"""Samples per pixel of the PNG colour types without a palette."""
FILTERS = range(5)


def chunk(name: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def png(
    pixels: np.ndarray, kind: int, filters: np.ndarray, *, level: int = 6, parts: int = 1, extra: bytes = b""
) -> bytes:
    """A PNG of `pixels` (h, w, samples) as a strange encoder would write it: a filter for every row, data in parts."""
    height, width, samples = pixels.shape
    step = samples * pixels.dtype.itemsize
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(height, -1).view(np.uint8).astype(int)
    above = np.zeros_like(rows[0])
    raw = b""
    for row, filter in zip(rows, filters, strict=True):
        left, corner = (np.concatenate([np.zeros(step, int), line[:-step]]) for line in (row, above))
        estimate = left + above - corner
        distances = np.abs(estimate - np.stack([left, above, corner]))
        paeth = np.choose(distances.argmin(axis=0), [left, above, corner])
        prediction = [0 * row, left, above, (left + above) // 2, paeth][filter]
        raw += bytes([filter]) + ((row - prediction) % 256).astype(np.uint8).tobytes()
        above = row
    data = zlib.compress(raw, level)
    cuts = pairwise(np.linspace(0, len(data), parts + 1).astype(int))
    header = struct.pack(">IIBBBBB", width, height, 8 * pixels.dtype.itemsize, kind, 0, 0, 0)
    body = b"".join(chunk(b"IDAT", data[start:stop]) for start, stop in cuts)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + extra + body + chunk(b"IEND", b"")


def some_pixels(rng: np.random.Generator, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """Noise, a smooth picture with noise, or nothing but one level."""
    white = np.iinfo(dtype).max
    v, u = np.mgrid[: shape[0], : shape[1]]
    smooth = (0.4 + 0.3 * np.sin(u / 9) + 0.2 * np.cos(v / 5))[..., None] + rng.normal(0, 0.01, shape)
    noise = rng.random(shape)
    levels = [noise, smooth, np.full(shape, rng.random())][rng.integers(3)]
    return (levels.clip(0, 1) * white).astype(dtype)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_every_png_decodes_to_what_its_encoder_was_given_both_ways(kind: int, dtype: type) -> None:
    rng = np.random.default_rng([kind, np.iinfo(dtype).bits])
    for _ in range(60):
        shape = (int(rng.integers(1, 40)), int(rng.integers(1, 60)), KINDS[kind])
        pixels = some_pixels(rng, shape, dtype)
        filters = rng.choice(FILTERS, shape[0])
        file = png(pixels, kind, filters, level=int(rng.integers(10)), parts=int(rng.integers(1, 5)))
        expected = pixels[..., : 1 if kind in (0, 4) else 3]
        expected = expected[..., 0] if kind in (0, 4) else expected
        for simple in (True, False):
            decoded = decode_image(file, simple=simple)
            assert decoded.dtype == dtype
            assert np.array_equal(decoded, expected)


@pytest.mark.parametrize("filter", FILTERS)
def test_a_large_png_of_one_filter_decodes_the_same_both_ways(filter: int) -> None:
    pixels = some_pixels(np.random.default_rng(filter), (300, 517, 3), np.uint8)
    file = png(pixels, 2, np.full(300, filter))
    assert np.array_equal(decode_image(file), pixels)
    assert np.array_equal(decode_image(file, simple=False), pixels)


def test_chunks_beside_the_pixels_do_not_change_them() -> None:
    pixels = some_pixels(np.random.default_rng(3), (11, 13, 3), np.uint8)
    beside = [
        chunk(b"gAMA", struct.pack(">I", 45455)),
        chunk(b"tEXt", b"Comment\0" + 900 * b"x"),
        chunk(b"pHYs", 9 * b"\1"),
    ]
    beside += [chunk(b"tRNS", 6 * b"\0"), chunk(b"PLTE", 9 * b"\7"), chunk(b"prVt", b"own")]
    beside += [chunk(b"gAMA", b"wrong")]
    for extra in [*beside, b"".join(beside[:3])]:
        file = png(pixels, 2, np.arange(11) % 5, extra=extra)
        assert np.array_equal(decode_image(file), pixels)


def outcome(file: bytes, **options: bool) -> np.ndarray | str:
    try:
        return decode_image(file, **options)
    except ValueError as error:
        return str(error)


def test_a_damaged_file_is_told_in_the_same_words_both_ways() -> None:
    rng = np.random.default_rng(8)
    whole = png(some_pixels(rng, (9, 14, 3), np.uint8), 2, np.arange(9) % 5, parts=2)
    files = [whole[:length] for length in range(0, len(whole), 3)]
    for _ in range(1500):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), rng.integers(1, 4)):
            damaged[place] ^= 1 << int(rng.integers(8))
        files.append(bytes(damaged))
    files += [mended(file) for file in files[-600:]]
    for file in files:
        simple, general = outcome(file), outcome(file, simple=False)
        assert simple == general if isinstance(simple, str) else np.array_equal(simple, general)


def mended(file: bytes) -> bytes:
    """With the right checksum in every chunk: damage that only inflating or unfiltering can find."""
    out, at = file[:8], 8
    while at + 12 <= len(file):
        length = struct.unpack(">I", file[at : at + 4])[0]
        out += chunk(file[at + 4 : at + 8], file[at + 8 : at + 8 + length])
        at += 12 + length
    return out


def test_a_png_whose_data_hold_too_little_or_too_much_is_judged_the_same_both_ways() -> None:
    pixels = some_pixels(np.random.default_rng(5), (12, 10, 3), np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 10, 12, 8, 2, 0, 0, 0))
    wrong_sum = zlib.compress(rows)[:-4] + b"\0\0\0\0"
    streams = [zlib.compress(rows[:-1]), zlib.compress(rows[:-31]), zlib.compress(rows + b"\0"), wrong_sum]
    streams += [
        zlib.compress(rows) + b"more",
        zlib.compress(b""),
        b"",
        zlib.compress(rows)[:-4],
        zlib.compress(rows)[:-9],
    ]
    for data in streams:
        file = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", data) + chunk(b"IEND", b"")
        simple, general = outcome(file), outcome(file, simple=False)
        assert simple == general if isinstance(simple, str) else np.array_equal(simple, general)


def test_a_small_file_that_declares_a_huge_picture_costs_no_memory() -> None:
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 16000, 16000, 8, 2, 0, 0, 0))
    file = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")
    assert outcome(file) == outcome(file, simple=False)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3])
def test_an_uncompressed_tiff_decodes_the_same_both_ways(dtype: type, channels: int) -> None:
    rng = np.random.default_rng(6)
    for height, width in [(1, 1), (7, 5), (64, 33), (300, 411)]:
        pixels = some_pixels(rng, (height, width, channels), dtype)
        given = pixels[..., 0] if channels == 1 else pixels
        reversed_ = given if channels == 1 else np.ascontiguousarray(given[..., ::-1])
        options = [cv2.IMWRITE_TIFF_COMPRESSION, 1]
        files = [cv2.imencode(".tif", reversed_, options)[1].tobytes()]
        if dtype == np.uint8:
            files.append(saved(Image.fromarray(given), "TIFF"))
        for file in files:
            assert np.array_equal(decode_image(file), given)
            assert np.array_equal(decode_image(file, simple=False), given)


def saved(image: Image.Image, format: str) -> bytes:
    file = io.BytesIO()
    image.save(file, format)
    return file.getvalue()


@pytest.mark.parametrize("mode", ["L", "RGB", "I;16"])
def test_a_pgm_or_ppm_gives_back_the_pixels_it_was_made_from(mode: str) -> None:
    shape = (23, 31, 3) if mode == "RGB" else (23, 31, 1)
    pixels = some_pixels(np.random.default_rng(7), shape, np.uint16 if mode == "I;16" else np.uint8)
    pixels = pixels if mode == "RGB" else pixels[..., 0]
    file = saved(Image.fromarray(pixels), "PPM")
    assert image_size(file) == (31, 23)
    assert np.array_equal(decode_image(file), pixels)
    by_opencv = np.ascontiguousarray(pixels[..., ::-1]) if mode == "RGB" else pixels
    extension = ".ppm" if mode == "RGB" else ".pgm"
    assert np.array_equal(decode_image(cv2.imencode(extension, by_opencv)[1].tobytes()), pixels)


def test_comments_and_any_white_space_may_stand_before_the_pixels_of_a_pgm() -> None:
    pixels = np.arange(6, dtype=np.uint8).reshape(2, 3)
    for text in (b"P5 3 2 255\n", b"P5\n# by a camera\n3 2\n255\n", b"P5#c\r\n\t3#d\n 2\n\n255 "):
        assert np.array_equal(decode_image(text + pixels.tobytes()), pixels)


def test_levels_of_a_camera_of_twelve_bits_are_scaled_so_that_its_white_is_white() -> None:
    levels = np.array([[0, 1, 2047, 4095]], dtype=">u2")
    decoded = decode_image(b"P5 4 1 4095\n" + levels.tobytes())
    assert decoded.dtype == np.uint16
    assert np.array_equal(decoded, np.floor(levels.astype(float) * 65535 / 4095 + 0.5))
    assert decode_image(b"P5 2 1 15\n\x0f\x01").tolist() == [[255, 17]]


@pytest.mark.parametrize(
    ("file", "why"),
    [
        (b"P5 3 2 255\nabcde", "truncated"),
        (b"P5 3 2", "truncated"),
        (b"P6 3 2 255", "truncated"),
        (b"P5 0 2 255\n", "0 x 2"),
        (b"P5 3 2 0\nabcdef", "corrupt"),
        (b"P5 3 2 70000\nabcdef", "corrupt"),
        (b"P5 3 -2 255\nabcdef", "corrupt"),
        (b"P5 3 2 255abcdef", "corrupt"),
        (b"P5 99999999999999999999 2 255\n", "corrupt"),
        (b"P5 60000 60000 255\n", "limit"),
        (b"P5 2 1 15\n\x0f\x10", "brighter"),
        (b"P5 " + 5000 * b" ", "truncated"),
        (b"P4 8 1\n\xff", "not a PNG"),
    ],
)
def test_a_damaged_pgm_is_told(file: bytes, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        decode_image(file)

"""The Rust decoder against Pillow and OpenCV, and against damaged files."""

import io
import struct
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
from calibore._native import decode_image, image_size
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

JPEG_LEVELS = 4  # two inverse cosine transforms and colour conversions, each correct to rounding, may differ by so much


def picture(height: int, width: int, *, channels: int = 3) -> np.ndarray:
    v, u = np.mgrid[:height, :width]
    colours = np.stack([(3 * u) % 256, (4 * v) % 256, (u * v) % 256], axis=-1).astype(np.uint8)
    return colours if channels == 3 else colours[..., 0]


def smooth(height: int, width: int) -> np.ndarray:
    v, u = np.mgrid[:height, :width]
    return np.stack([60 + u / 2, 200 - v / 2, 80 + (u + v) / 4], axis=-1).clip(0, 255).astype(np.uint8)


def encoded(image: Image.Image, format: str, **options: object) -> bytes:
    file = io.BytesIO()
    image.save(file, format, **options)
    return file.getvalue()


def with_opencv(extension: str, pixels: np.ndarray) -> bytes:
    return cv2.imencode(extension, pixels)[1].tobytes()


LOSSLESS = [
    ("PNG", {}),
    ("BMP", {}),
    ("TIFF", {}),
    ("TIFF", {"compression": "tiff_lzw"}),
    ("TIFF", {"compression": "tiff_adobe_deflate"}),
    ("TIFF", {"compression": "packbits"}),
]


@pytest.mark.parametrize(("format", "options"), LOSSLESS)
@pytest.mark.parametrize("mode", ["L", "RGB"])
def test_a_lossless_file_gives_back_the_pixels_it_was_made_from(format: str, options: dict, mode: str) -> None:
    for height, width in [(1, 1), (1, 7), (61, 83), (64, 3)]:
        pixels = picture(height, width, channels=len(mode))
        assert np.array_equal(decode_image(encoded(Image.fromarray(pixels), format, **options)), pixels)


@pytest.mark.parametrize("extension", [".png", ".tiff"])
@pytest.mark.parametrize("shape", [(41, 53), (41, 53, 3)])
def test_sixteen_bits_arrive_with_all_their_levels_and_red_first(extension: str, shape: tuple[int, ...]) -> None:
    pixels = np.random.default_rng(1).integers(0, 65536, shape, dtype=np.uint16)
    decoded = decode_image(with_opencv(extension, pixels))
    assert decoded.dtype == np.uint16
    assert np.array_equal(decoded, pixels if pixels.ndim == 2 else pixels[..., ::-1])


@pytest.mark.parametrize("mode", ["L", "RGB"])
@pytest.mark.parametrize("options", [{}, {"progressive": True}, {"optimize": True}, {"restart_marker_blocks": 3}])
@pytest.mark.parametrize("subsampling", [0, 1, 2])
def test_a_jpeg_agrees_with_pillow_within_rounding(mode: str, options: dict, subsampling: int) -> None:
    for height, width in [(8, 8), (16, 17), (61, 83), (1, 1), (200, 9)]:
        pixels = smooth(height, width)
        source = Image.fromarray(pixels).convert(mode)
        file = encoded(source, "JPEG", quality=90, subsampling=subsampling, **options)
        expected = np.array(Image.open(io.BytesIO(file))).astype(int)
        decoded = decode_image(file)
        assert decoded.shape == expected.shape
        assert np.abs(decoded.astype(int) - expected).max() <= JPEG_LEVELS


@pytest.mark.parametrize("format", ["PNG", "TIFF"])
@pytest.mark.parametrize("mode", ["LA", "RGBA"])
def test_alpha_is_dropped_and_the_colours_are_untouched(format: str, mode: str) -> None:
    pixels = np.random.default_rng(2).integers(0, 256, (21, 34, len(mode)), dtype=np.uint8)
    expected = pixels[..., 0] if mode == "LA" else pixels[..., :3]
    assert np.array_equal(decode_image(encoded(Image.fromarray(pixels, mode), format)), expected)


@pytest.mark.parametrize("format", ["PNG", "TIFF", "BMP"])
def test_a_palette_becomes_its_colours(format: str) -> None:
    indexed = Image.fromarray(smooth(40, 60)).quantize(50)
    assert np.array_equal(decode_image(encoded(indexed, format)), np.array(indexed.convert("RGB")))


@pytest.mark.parametrize("format", ["PNG", "TIFF", "BMP"])
def test_a_grey_palette_becomes_grey(format: str) -> None:
    indexed = Image.fromarray(picture(20, 30, channels=1), "P")
    indexed.putpalette([level for grey in range(256) for level in (grey, grey, grey)])
    assert np.array_equal(decode_image(encoded(indexed, format)), picture(20, 30, channels=1))


@pytest.mark.parametrize(
    ("format", "options"), [("PNG", {}), ("BMP", {}), ("TIFF", {}), ("TIFF", {"compression": "packbits"})]
)
def test_one_bit_becomes_black_and_white(format: str, options: dict) -> None:
    bits = np.random.default_rng(3).random((19, 37)) > 0.5
    assert np.array_equal(decode_image(encoded(Image.fromarray(bits), format, **options)), bits * np.uint8(255))


def test_tiff_with_white_as_zero_is_not_negative() -> None:
    grey = picture(15, 25, channels=1)
    file = encoded(Image.fromarray(grey), "TIFF", tiffinfo={262: 0})
    assert (255 - grey).tobytes() in file
    assert np.array_equal(decode_image(file), grey)


def test_tiff_of_either_byte_order_and_in_planes_is_read() -> None:
    pixels = np.random.default_rng(4).integers(0, 65536, (9, 11, 3), dtype=np.uint16)
    for order in "<>":
        for planar in (1, 2):
            stored = pixels if planar == 1 else np.moveaxis(pixels, 2, 0)
            assert np.array_equal(decode_image(tiff(stored.astype(f"{order}u2"), (9, 11), order, planar)), pixels)


def tiff(samples: np.ndarray, shape: tuple[int, int], order: str, planar: int) -> bytes:
    """A 16 bit colour TIFF written by hand: header, pixels, tag values, directory."""
    data = samples.tobytes()
    values_at = 8 + len(data)
    plane = len(data) // 3
    strips = [8] if planar == 1 else [8, 8 + plane, 8 + 2 * plane]
    counts = [len(data)] if planar == 1 else [plane] * 3
    values = struct.pack(f"{order}3H", 16, 16, 16) + b"\0\0"
    strips_at = values_at + len(values)
    values += struct.pack(f"{order}{len(strips)}I", *strips) + struct.pack(f"{order}{len(counts)}I", *counts)
    several = planar == 2
    entries = [
        (256, 4, 1, shape[1]),
        (257, 4, 1, shape[0]),
        (258, 3, 3, values_at),
        (259, 3, 1, 1),
        (262, 3, 1, 2),
        (273, 4, len(strips), strips_at if several else strips[0]),
        (277, 3, 1, 3),
        (278, 4, 1, shape[0]),
        (279, 4, len(counts), strips_at + 12 if several else counts[0]),
        (284, 3, 1, planar),
    ]
    directory = struct.pack(f"{order}H", len(entries))
    for tag, kind, count, value in entries:
        directory += struct.pack(f"{order}HHI", tag, kind, count)
        directory += (
            struct.pack(f"{order}HH", value, 0) if kind == 3 and count == 1 else struct.pack(f"{order}I", value)
        )
    start = {"<": b"II*\0", ">": b"MM\0*"}[order]
    return start + struct.pack(f"{order}I", values_at + len(values)) + data + values + directory + b"\0\0\0\0"


@pytest.mark.parametrize("bits", [16, 32])
def test_bmp_of_sixteen_and_thirty_two_bits_and_from_the_top_agrees_with_pillow(bits: int) -> None:
    rng = np.random.default_rng(5)
    for height in (5, -5):
        stride = (7 * bits + 31) // 32 * 4
        header = struct.pack("<IiiHHIIiiII", 40, 7, height, 1, bits, 0, 0, 0, 0, 0, 0)
        file = b"BM" + struct.pack("<IHHI", 54 + 5 * stride, 0, 0, 54) + header + rng.bytes(5 * stride)
        expected = np.array(Image.open(io.BytesIO(file)).convert("RGB")).astype(int)
        tolerance = 1 if bits == 16 else 0  # five bits to eight: rounded or replicated
        assert np.abs(decode_image(file).astype(int) - expected).max() <= tolerance


def test_interlaced_png_is_read() -> None:
    pixels = picture(13, 17)
    assert np.array_equal(decode_image(interlaced_png(pixels)), pixels)


def interlaced_png(pixels: np.ndarray) -> bytes:
    """An Adam7 PNG written by hand."""
    passes = [(0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)]
    rows = b""
    for v, u, dv, du in passes:
        part = pixels[v::dv, u::du]
        rows += b"".join(b"\0" + row.tobytes() for row in part if row.size)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 2, 0, 0, 1)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )


SMALL = picture(23, 31)
FILES = {
    "png": encoded(Image.fromarray(SMALL), "PNG"),
    "png16": with_opencv(".png", SMALL.astype(np.uint16) * 257),
    "png palette": encoded(Image.fromarray(SMALL).quantize(20), "PNG"),
    "jpeg": encoded(Image.fromarray(SMALL), "JPEG", quality=85),
    "jpeg grey": encoded(Image.fromarray(SMALL).convert("L"), "JPEG"),
    "jpeg progressive": encoded(Image.fromarray(SMALL), "JPEG", progressive=True),
    "jpeg restart": encoded(Image.fromarray(SMALL), "JPEG", restart_marker_blocks=2),
    "tiff": encoded(Image.fromarray(SMALL), "TIFF"),
    "tiff lzw": encoded(Image.fromarray(SMALL), "TIFF", compression="tiff_lzw"),
    "tiff palette": encoded(Image.fromarray(SMALL).quantize(20), "TIFF", compression="tiff_adobe_deflate"),
    "bmp": encoded(Image.fromarray(SMALL), "BMP"),
    "bmp palette": encoded(Image.fromarray(SMALL).quantize(20), "BMP"),
}


@pytest.mark.parametrize("kind", FILES)
def test_a_file_cut_anywhere_is_an_error_or_complete(kind: str) -> None:
    file = FILES[kind]
    whole = decode_image(file)
    for length in range(len(file)):
        try:
            decoded = decode_image(file[:length])
        except ValueError:
            continue
        assert np.array_equal(decoded, whole)  # only what comes after the pixels was cut off


@pytest.mark.parametrize("kind", ["jpeg", "jpeg grey", "jpeg restart"])
def test_a_jpeg_that_ends_properly_but_too_early_is_an_error(kind: str) -> None:
    file = FILES[kind]
    start = file.index(b"\xff\xda") + 14
    for length in range(start, len(file) - 4):
        with pytest.raises(ValueError, match=r"corrupt|truncated"):
            decode_image(file[:length] + b"\xff\xd9")


def test_a_flipped_bit_in_png_pixels_is_always_found() -> None:
    file = FILES["png"]
    start, end = file.index(b"IDAT"), file.index(b"IEND") - 4
    for position in range(start + 4, end):
        damaged = bytearray(file)
        damaged[position] ^= 1 << position % 8
        with pytest.raises(ValueError, match=r"corrupt|truncated"):
            decode_image(bytes(damaged))


@settings(max_examples=600, deadline=None)
@given(
    st.sampled_from(sorted(FILES)),
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=6),
    st.floats(0, 1),
)
def test_a_damaged_file_gives_an_image_or_a_value_error(kind: str, flips: list[tuple[float, int]], kept: float) -> None:
    data = bytearray(FILES[kind][: int(np.ceil(kept * len(FILES[kind])))])
    for place, pattern in flips:
        if data:
            data[int(place * len(data))] ^= pattern
    check_never_worse_than_value_error(bytes(data))


@settings(max_examples=400, deadline=None)
@given(
    st.sampled_from([b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0\x08\0\0\0", b"MM\0*\0\0\0\x08", b"BM"]),
    st.binary(max_size=300),
)
def test_random_bytes_give_an_image_or_a_value_error(start: bytes, rest: bytes) -> None:
    check_never_worse_than_value_error(start + rest)


def check_never_worse_than_value_error(data: bytes) -> None:
    try:
        decoded = decode_image(data, limit=50_000_000)
    except ValueError:
        pass
    else:
        assert decoded.ndim in (2, 3)
        assert decoded.dtype in (np.uint8, np.uint16)
    try:
        width, height = image_size(data)
    except ValueError:
        return
    assert width >= 0
    assert height >= 0


def test_an_image_larger_than_the_limit_is_refused_before_it_is_decoded() -> None:
    huge = FILES["png"][:16] + struct.pack(">II", 2**31 - 1, 2**31 - 1)
    body = b"IHDR" + huge[16:24] + FILES["png"][24:29]
    file = FILES["png"][:12] + body + struct.pack(">I", zlib.crc32(body)) + FILES["png"][33:]
    began = time.perf_counter()
    with pytest.raises(ValueError, match="limit"):
        decode_image(file)
    assert time.perf_counter() - began < 1
    for kind in FILES:
        with pytest.raises(ValueError, match=r"[Ll]imit"):
            decode_image(FILES[kind], limit=600)


@pytest.mark.parametrize("kind", FILES)
def test_the_header_tells_the_size_of_the_image(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "name with spaces"
    path.write_bytes(FILES[kind])
    assert image_size(path) == image_size(FILES[kind]) == (31, 23)
    assert np.array_equal(decode_image(path), decode_image(FILES[kind]))


def test_threads_decode_the_same_pixels() -> None:
    expected = {kind: decode_image(file) for kind, file in FILES.items()}
    kinds = sorted(FILES) * 20
    with ThreadPoolExecutor(4) as threads:
        for kind, decoded in zip(kinds, threads.map(lambda kind: decode_image(FILES[kind]), kinds), strict=True):
            assert np.array_equal(decoded, expected[kind])


def test_a_folder_or_a_missing_file_is_an_os_error(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "absent.png"):
        with pytest.raises(OSError):
            decode_image(path)


def test_the_simulated_plane_decodes_as_pillow_does() -> None:
    folder = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "plane-12in"
    if not folder.is_dir():
        pytest.skip(f"simulated data are not at {folder}")
    for path in sorted(folder.glob("*.png"))[:4]:
        assert np.array_equal(decode_image(path), np.array(Image.open(path)))

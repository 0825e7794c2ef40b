"""Small image files of every kind that the decoders know, and bytes that the kernels' targets read as arguments."""

import io
from collections.abc import Iterator

import numpy as np
from PIL import Image

SIZES = ((9, 7), (33, 18), (1, 1))
"""(w, h) [px]: neither is a whole number of blocks."""
MODES = ("1", "L", "P", "RGB", "RGBA", "LA", "I;16")


def pictures(kind: str) -> list[bytes]:
    """Files of a kind in `PICTURES`."""
    return list(PICTURES[kind]())


def arguments(count: int = 40) -> list[bytes]:
    """Random arguments, of growing length."""
    rng = np.random.default_rng(1)
    return [rng.bytes(20 * (i + 1)) for i in range(count)]


def _images(*modes: str) -> Iterator[Image.Image]:
    rng = np.random.default_rng(2)
    for width, height in SIZES:
        smooth = np.add.outer(7 * np.arange(height), 5 * np.arange(width))
        for mode in modes:
            if mode == "I;16":
                yield Image.fromarray((257 * smooth + rng.integers(0, 99, smooth.shape)).astype(np.uint16))
            else:
                colour = np.stack([smooth, smooth[::-1], 255 - smooth], axis=-1).clip(0, 255).astype(np.uint8)
                yield Image.fromarray(colour).convert(mode)


def _saved(image: Image.Image, kind: str, **options: object) -> bytes:
    file = io.BytesIO()
    image.save(file, kind, **options)
    return file.getvalue()


def _png() -> Iterator[bytes]:
    for image in _images(*MODES):
        yield _saved(image, "png")
    for image in _images("P"):
        yield from (_saved(image, "png", bits=bits) for bits in (2, 4))
    for image in _images("L", "RGB"):
        yield _saved(image, "png", compress_level=0)
        yield _saved(image, "png", transparency=0 if image.mode == "L" else (0, 0, 0))


def _jpeg() -> Iterator[bytes]:
    for image in _images("L", "RGB", "CMYK"):
        for progressive in (False, True):
            for sampling in (0, 1, 2):
                yield _saved(image, "jpeg", quality=70, progressive=progressive, subsampling=sampling)
        yield _saved(image, "jpeg", restart_marker_blocks=1)


def _tiff() -> Iterator[bytes]:
    for compression in ("raw", "packbits", "tiff_lzw", "tiff_adobe_deflate"):
        for image in _images("1", "L", "P", "RGB", "RGBA", "I;16"):
            yield _saved(image, "tiff", compression=compression)
    for image in _images("L", "RGB"):
        yield _saved(image, "tiff", compression="jpeg")
        yield _saved(image, "tiff", big_tiff=True)


def _bmp() -> Iterator[bytes]:
    for image in _images("1", "L", "P", "RGB", "RGBA"):
        yield _saved(image, "bmp")


def _pnm() -> Iterator[bytes]:
    for image in _images("L", "RGB", "I;16"):
        yield _saved(image, "ppm")


PICTURES = {"png": _png, "jpeg": _jpeg, "tiff": _tiff, "bmp": _bmp, "pnm": _pnm}

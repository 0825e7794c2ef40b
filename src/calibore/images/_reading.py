"""One image file to an array, through the Rust decoder."""

from pathlib import Path

from calibore._native import decode_image
from calibore._native import image_size as _native_size
from calibore.errors import ImageError
from calibore.images._source import Pixels

LIMIT = 1_000_000_000
"""Most bytes that one image may have, decoded or as a file."""


class ImageFileError(ImageError):
    """A file that is not a usable image; `reason` says why and what to do without naming it again."""

    def __init__(self, path: Path, why: str) -> None:
        self.reason = f"{why}; copy or save it again, or remove it"
        super().__init__(f'Image "{path}" cannot be used: {self.reason}.')


def read_image(path: Path, *, limit: int = LIMIT) -> Pixels:
    """The pixels of a PNG, JPEG, TIFF, BMP, PGM or PPM file, shape (h, w) or (h, w, 3), 8 or 16 bit.

    A palette becomes its colours (grey where all are grey). Binary PGM and PPM are read; their levels are scaled where
    white is neither 255 nor 65535. Raises ImageError naming the file and why: truncated, corrupt, empty, not an image,
    larger than `limit` bytes, unreadable.
    """
    try:
        return decode_image(path, limit=limit)
    except (ValueError, OSError) as error:
        raise _image_error(path, error) from error


def image_size(path: Path) -> tuple[int, int]:
    """(width, height) [px] from the header alone; raises ImageError."""
    try:
        return _native_size(path)
    except (ValueError, OSError) as error:
        raise _image_error(path, error) from error


def _image_error(path: Path, error: Exception) -> ImageFileError:
    why = str(error)
    if isinstance(error, OSError):
        why = f"it cannot be read ({error.strerror or why.split(' (os error')[0]})"
    return ImageFileError(path, why)

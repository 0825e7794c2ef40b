"""One picture as one file of a Zarr v3 array: a shard whose chunks are the colour planes, zstd, each with its CRC-32C.

The files are an ordinary Zarr; they are packed and unpacked here because zarr-python needs several times as long for a
chunk as its decompression takes (docs/reference/archive.md).
"""

import os
import re
import struct
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore._native import interleave
from calibore.images._source import Pixels

CHANNELS = ("red", "green", "blue")
ZSTD_LEVEL = 12
"""8 bit: 3 % smaller and 15 % faster to read than level 9, at twice the time of writing; level 15 takes ten times."""
BLOSC_LEVEL = 7
"""16 bit: zstd of the bytes sorted by place, so that the high bytes, nearly all equal, stand together."""
CRC = struct.Struct("<I")
KEPT = 1 << 26
"""Most bytes that a thread keeps between pictures: fresh memory costs the system a page fault for every 4 kB."""
_ROOM = threading.local()
_NAME = re.compile(r"(grey|colour)(8|16)_(\d+)x(\d+)")


class DamagedError(ValueError):
    """The bytes of an archived picture are not those that were written."""


@dataclass(frozen=True)
class Form:
    """What pictures of one array have in common: size [px], grey or colour, 8 or 16 bit."""

    width: int
    height: int
    colour: bool
    bits: int

    @classmethod
    def of(cls, pixels: Pixels) -> "Form":
        """The form of `pixels` (h, w) or (h, w, 3)."""
        return cls(pixels.shape[1], pixels.shape[0], pixels.ndim == 3, 8 * pixels.dtype.itemsize)

    @classmethod
    def named(cls, name: str) -> "Form | None":
        """The form whose array is called `name`; None where it is no such name."""
        found = _NAME.fullmatch(name)
        return found and cls(int(found[3]), int(found[4]), found[1] == "colour", int(found[2]))

    @property
    def name(self) -> str:
        """Of the array: colour8_1024x768."""
        return f"{'colour' if self.colour else 'grey'}{self.bits}_{self.width}x{self.height}"

    @property
    def planes(self) -> int:
        return len(CHANNELS) if self.colour else 1

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype(np.uint8 if self.bits == 8 else "<u2")

    @property
    def bytes(self) -> int:
        """Of one decoded picture."""
        return self.planes * self.height * self.width * self.dtype.itemsize

    def file(self, store: Path, number: int) -> Path:
        """Where Zarr keeps picture `number` of this form."""
        return store.joinpath(self.name, "c", str(number), *("0" * (2 + self.colour)))


def packed(pixels: Pixels) -> bytes:
    """The file of `pixels` (h, w) or (h, w, 3): its planes one after the other, then their places."""
    form, parts, places, end = Form.of(pixels), [], b"", 0
    planes = [pixels[:, :, band] for band in range(form.planes)] if form.colour else [pixels]
    for plane in planes:
        body = _codec(form).encode(np.ascontiguousarray(plane, form.dtype))
        parts.append(_sealed(body))
        places += struct.pack("<QQ", end, len(parts[-1]))
        end += len(parts[-1])
    return b"".join(parts) + _sealed(places)


def unpacked(data: bytes, form: Form) -> Pixels:
    """The pixels (h, w) or (h, w, 3) of a file; raises DamagedError."""
    places = _places(data[-index_size(form) :], form, len(data))
    if not form.colour:
        return _plane(data[slice(*places[0])], form)
    return interleave([_plane(data[slice(*place)], form, at) for place, at in zip(places, _room(form), strict=True)])


def _room(form: Form) -> NDArray[Any]:
    """Memory (3, h, w) for the planes of one picture, that of this thread's last one if it was of the same form."""
    room = getattr(_ROOM, "planes", None)
    shape = (form.planes, form.height, form.width)
    if room is None or room.shape != shape or room.dtype != form.dtype:
        room = np.empty(shape, form.dtype)
        _ROOM.planes = room if room.nbytes <= KEPT else None
    return room


def read_band(path: Path, form: Form, *, band: int) -> Pixels:
    """One plane (h, w) of a file, without reading the others; raises DamagedError or OSError."""
    with path.open("rb", buffering=0) as file:
        size, index = file.seek(0, os.SEEK_END), index_size(form)
        file.seek(max(size - index, 0))
        start, stop = _places(file.read(index), form, size)[band]
        file.seek(start)
        return _plane(file.read(stop - start), form)


def check(data: bytes, form: Form) -> None:
    """Raise DamagedError unless all of `data` is as it was written; nothing is decompressed."""
    for start, stop in _places(data[-index_size(form) :], form, len(data)):
        _opened(data[start:stop])


def index_size(form: Form) -> int:
    """Bytes at the end of a file that say where its planes are."""
    return 16 * form.planes + CRC.size


def _places(index: bytes, form: Form, size: int) -> list[tuple[int, int]]:
    """First byte and end of each plane, which together fill the file."""
    if len(index) != index_size(form):
        raise DamagedError("the file is cut short")
    numbers = struct.unpack(f"<{2 * form.planes}Q", _opened(index))
    places = [(start, start + length) for start, length in zip(numbers[::2], numbers[1::2], strict=True)]
    ends = [0, *(stop for _, stop in places)]
    if [*(start for start, _ in places), size - len(index)] != ends:
        raise DamagedError("the file is not as long as it says")
    return places


def _plane(sealed: bytes, form: Form, room: NDArray[Any] | None = None) -> NDArray[Any]:
    plane = np.empty((form.height, form.width), form.dtype) if room is None else room
    plane.fill(0)
    body = _opened(sealed)
    try:
        _codec(form).decode(body, out=plane)  # never writes more than `plane` holds, whatever the file says
    except (RuntimeError, ValueError) as error:
        raise DamagedError(str(error)) from error
    return plane


def _codec(form: Form) -> Any:
    from numcodecs.blosc import Blosc
    from numcodecs.zstd import Zstd

    return Zstd(ZSTD_LEVEL) if form.bits == 8 else Blosc("zstd", BLOSC_LEVEL, Blosc.SHUFFLE)


def _sealed(body: bytes) -> bytes:
    import google_crc32c

    return body + CRC.pack(google_crc32c.value(body))


def _opened(sealed: bytes) -> bytes:
    import google_crc32c

    body = sealed[: -CRC.size]
    if len(sealed) < CRC.size or google_crc32c.value(body) != CRC.unpack(sealed[-CRC.size :])[0]:
        raise DamagedError("its checksum does not match")
    return body

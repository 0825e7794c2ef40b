"""What has been measured so far, on the disk as soon as it is: a run that is killed loses nothing it has told.

One record after the other in one file: mark, lengths, check sum, a JSON header, then arrays as bytes. A record that a
kill has cut short ends the reading; everything before it is whole.
"""

import json
import os
import shutil
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

MARK = b"CLJ1"
_HEAD = struct.Struct("<4sIII")
FILE = "journal"
Arrays = dict[str, NDArray[Any]]


def journal_folder(out: Path) -> Path:
    """Where the journal of the run that makes the result `out` lies until it is complete."""
    out = Path(os.path.realpath(out))
    return out.with_name(f".{out.name}.live")


class Journal:
    """The journal of one run, appended to; `keep` records until the result is complete, then `remove`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._file: BinaryIO | None = None

    def begin(self, about: Mapping[str, Any]) -> None:
        """A new journal of a run that is told by `about`, or the end of one that is there."""
        self.folder.mkdir(parents=True, exist_ok=True)
        length = sum(size for _, _, size in self._records())
        self._file = (self.folder / FILE).open("ab", buffering=0)
        self._file.truncate(length)
        if not length:
            self.add({"kind": "run", **about})

    def add(self, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> None:
        """Append one record."""
        arrays = arrays or {}
        layout = [[name, array.dtype.str, list(array.shape)] for name, array in arrays.items()]
        head = json.dumps({**header, "arrays": layout}, default=_plain).encode()
        body = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays.values())
        frame = _HEAD.pack(MARK, len(head), len(body), zlib.crc32(body, zlib.crc32(head)))
        if self._file is None:
            raise RuntimeError("A journal is written between begin() and close().")
        self._file.write(frame + head + body)

    def about(self) -> dict[str, Any] | None:
        """What `begin` was told of the run that left this journal; None where there is none."""
        return next((header for header, _, _ in self._records() if header["kind"] == "run"), None)

    @property
    def empty(self) -> bool:
        """Whether it holds no ring."""
        return all(header["kind"] != "ring" for header, _, _ in self._records())

    @property
    def rings(self) -> int:
        """How many rings it holds."""
        return sum(header["kind"] == "ring" for header, _, _ in self._records())

    def records(self) -> Iterator[tuple[dict[str, Any], Arrays]]:
        """Header and arrays of every whole record."""
        yield from ((header, arrays) for header, arrays, _ in self._records())

    def _records(self) -> Iterator[tuple[dict[str, Any], Arrays, int]]:
        try:
            file = (self.folder / FILE).open("rb")
        except FileNotFoundError:
            return
        except OSError as error:
            raise InputError(f"{self.folder / FILE} cannot be read ({error.strerror}).") from error
        with file:
            while (found := _record(file)) is not None:
                yield found

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def remove(self) -> None:
        """The result is complete, or there is nothing to keep."""
        self.close()
        with suppress(OSError):
            (self.folder / FILE).unlink()
        shutil.rmtree(self.folder, ignore_errors=True)


def _record(file: BinaryIO) -> tuple[dict[str, Any], Arrays, int] | None:
    frame = file.read(_HEAD.size)
    if len(frame) < _HEAD.size:
        return None
    mark, head_size, body_size, check = _HEAD.unpack(frame)
    left = os.fstat(file.fileno()).st_size - file.tell()
    if mark != MARK or head_size + body_size > left:
        return None
    head, body = file.read(head_size), file.read(body_size)
    if zlib.crc32(body, zlib.crc32(head)) != check:
        return None
    header, arrays, start = json.loads(head), {}, 0
    for name, kind, shape in header.pop("arrays"):
        count = int(np.prod(shape, dtype=np.int64))
        arrays[name] = np.frombuffer(body, np.dtype(kind), count, start).reshape(shape)
        start += arrays[name].nbytes
    return header, arrays, _HEAD.size + head_size + body_size


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else str(value)

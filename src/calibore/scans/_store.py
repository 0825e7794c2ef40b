"""A Zarr v3 group that grows along one dimension, chunk by chunk, with bytes that depend on the data only.

The files are those that zarr-python would write (a test compares); they are written here because that takes it 0.1 s
for the arrays of a small survey, and as long to be imported.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.scans._layout import Variable

# A one-dimensional station variable would otherwise become one 256 byte file per chunk of stations.
SHORTEST_CHUNK = 4096
ZSTD_LEVEL = 3


class GrowingGroup:
    """Arrays appended along dimension `growing`, `rows` at a time; never holds more than `rows` of what has more
    dimensions, and `SHORTEST_CHUNK` numbers of what has one, plus one block.
    """

    def __init__(
        self,
        folder: Path,
        variables: Sequence[Variable],
        *,
        growing: str,
        rows: int,
        sizes: Mapping[str, int],
        attributes: Mapping[str, Any],
    ) -> None:
        folder.mkdir()
        self._folder, self._attributes = folder, dict(attributes)
        self._arrays = {v.name: _Array(folder, v, growing=growing, rows=rows, sizes=sizes) for v in variables}

    def fill(self, name: str, values: NDArray[Any]) -> None:
        """Values of a variable that does not grow."""
        self._arrays[name].append(values)

    def append(self, block: Mapping[str, NDArray[Any]]) -> None:
        """Add a block: one array per growing variable, of equal length along the growing dimension."""
        for name, values in block.items():
            self._arrays[name].append(values)

    def close(self) -> None:
        """Write what waits, and the metadata."""
        documents = {name: array.close() for name, array in sorted(self._arrays.items())}
        members = {"kind": "inline", "must_understand": False, "metadata": documents}
        group = {"attributes": self._attributes, "zarr_format": 3, "consolidated_metadata": members}
        text = json.dumps({**group, "node_type": "group"}, separators=(",", ":"))
        (self._folder / "zarr.json").write_text(text, encoding="utf-8")


class _Array:
    """One array, cut into chunks along its growing dimension only."""

    def __init__(self, folder: Path, variable: Variable, *, growing: str, rows: int, sizes: Mapping[str, int]) -> None:
        self._folder, self._variable = folder / variable.name, variable
        self._shape = [sizes.get(dimension, 0) for dimension in variable.dimensions]
        self._chunk = [max(size, 1) for size in self._shape]
        self._axis = variable.dimensions.index(growing) if growing in variable.dimensions else 0
        if growing in variable.dimensions:
            self._chunk[self._axis] = rows if len(variable.dimensions) > 1 else max(rows, SHORTEST_CHUNK)
        self._shape[self._axis] = 0
        self._pending: list[NDArray[Any]] = []
        self._waiting = self._chunks = 0
        (self._folder / "c").mkdir(parents=True)

    def append(self, values: NDArray[Any]) -> None:
        self._pending.append(values)
        self._waiting += values.shape[self._axis]
        self._shape[self._axis] += values.shape[self._axis]
        length = self._chunk[self._axis]
        if self._waiting < length:
            return
        values = self._joined()
        while self._waiting >= length:
            now, values = np.split(values, [length], axis=self._axis)
            self._write(now)
            self._waiting -= length
        # A copy, so that the whole concatenated block can be freed.
        self._pending = [values.copy()] if self._waiting else []

    def close(self) -> dict[str, Any]:
        """Write what waits and the metadata, which is returned."""
        if self._waiting:
            self._write(self._joined())
        document = self._metadata()
        (self._folder / "zarr.json").write_text(json.dumps(document, indent=2), encoding="utf-8")
        if not any((self._folder / "c").iterdir()):
            (self._folder / "c").rmdir()
        return document

    def _joined(self) -> NDArray[Any]:
        dtype = np.dtype(self._variable.dtype).newbyteorder("<")
        return np.concatenate(self._pending, axis=self._axis, dtype=dtype, casting="same_kind")

    def _write(self, values: NDArray[Any]) -> None:
        """The next chunk; one of nothing but the fill value is left out, as Zarr leaves it out."""
        place = ["0"] * len(self._chunk)
        place[self._axis] = str(self._chunks)
        self._chunks += 1
        missing = np.isnan(values) if values.dtype.kind == "f" else values == 0
        if missing.all():
            return
        chunk = np.full(self._chunk, np.nan if values.dtype.kind == "f" else 0, values.dtype)
        chunk[tuple(slice(size) for size in values.shape)] = values
        file = self._folder.joinpath("c", *place)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(_compressed(chunk))

    def _metadata(self) -> dict[str, Any]:
        dtype = np.dtype(self._variable.dtype)
        endian = {"configuration": {"endian": "little"}} if dtype.itemsize > 1 else {}
        return {
            "shape": self._shape,
            "data_type": dtype.name,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": self._chunk}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": "NaN" if dtype.kind == "f" else 0,
            "codecs": [
                {"name": "bytes", **endian},
                {"name": "zstd", "configuration": {"level": ZSTD_LEVEL, "checksum": False}},
            ],
            "attributes": self._variable.attributes,
            "dimension_names": list(self._variable.dimensions),
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }


def _compressed(chunk: NDArray[Any]) -> bytes:
    from numcodecs.zstd import Zstd

    return bytes(Zstd(ZSTD_LEVEL).encode(chunk))

"""A Zarr v3 group that grows along one dimension, chunk by chunk, with bytes that depend on the data only."""

import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.scans._layout import Variable

# A one-dimensional station variable would otherwise become one 256 byte file per chunk of stations.
SHORTEST_CHUNK = 4096


class GrowingGroup:
    """Arrays appended along dimension `growing`, `rows` at a time; never holds more than `rows` plus one block."""

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
        self._folder, self._growing, self._rows = folder, growing, rows
        self._variables, self._sizes, self._attributes = variables, sizes, attributes
        self._axis = {v.name: v.dimensions.index(growing) for v in variables if growing in v.dimensions}
        self._fixed: dict[str, NDArray[Any]] = {}
        self._pending: list[Mapping[str, NDArray[Any]]] = []
        self._waiting = self._written = 0
        self._arrays: dict[str, Any] = {}

    def _create(self, count: int) -> None:
        """The arrays, as long as what is written first: a short survey is created once and never resized."""
        import zarr

        group = zarr.create_group(self._folder, zarr_format=3, attributes=dict(self._attributes))
        self._arrays = {v.name: self._array(group, v, count) for v in self._variables}
        for name, values in self._fixed.items():
            self._arrays[name][:] = values

    def _array(self, group: Any, variable: Variable, count: int) -> Any:
        from zarr.codecs import ZstdCodec

        growing_chunk = self._rows if len(variable.dimensions) > 1 else max(self._rows, SHORTEST_CHUNK)
        return group.create_array(
            variable.name,
            shape=tuple(count if d == self._growing else self._sizes[d] for d in variable.dimensions),
            chunks=tuple(growing_chunk if d == self._growing else max(self._sizes[d], 1) for d in variable.dimensions),
            dtype=variable.dtype,
            fill_value=float("nan") if variable.dtype.startswith("float") else 0,
            compressors=ZstdCodec(level=3),
            dimension_names=variable.dimensions,
            attributes=variable.attributes,
        )

    def fill(self, name: str, values: NDArray[Any]) -> None:
        """Values of a variable that does not grow."""
        self._fixed[name] = values

    def append(self, block: Mapping[str, NDArray[Any]]) -> None:
        """Add a block: one array per growing variable, of equal length along the growing dimension."""
        first = next(iter(self._axis))
        self._pending.append(block)
        self._waiting += block[first].shape[self._axis[first]]
        if self._waiting >= self._rows:
            self._write(self._waiting - self._waiting % self._rows)

    def close(self) -> None:
        """Write what waits, and the consolidated metadata."""
        import zarr

        if self._waiting or not self._arrays:
            self._write(self._waiting)
        with warnings.catch_warnings():
            # Zarr warns that consolidated metadata is not in the v3 specification yet; xarray reads and writes it.
            warnings.simplefilter("ignore")
            zarr.consolidate_metadata(str(self._folder))
        _order_metadata(self._folder / "zarr.json")

    def _write(self, count: int) -> None:
        start, stop, rest = self._written, self._written + count, {}
        if not self._arrays:
            self._create(count)
        for name, axis in self._axis.items():
            array = self._arrays[name]
            values = np.concatenate(
                [block[name] for block in self._pending], axis=axis, dtype=array.dtype, casting="same_kind"
            )
            now, rest[name] = np.split(values, [count], axis=axis)
            if array.shape[axis] < stop:
                array.resize(tuple(stop if i == axis else size for i, size in enumerate(array.shape)))
            if now.size:
                array[(slice(None),) * axis + (slice(start, stop),)] = now
        self._written, self._waiting = stop, self._waiting - count
        # A copy, so that the whole concatenated block can be freed.
        self._pending = [{name: values.copy() for name, values in rest.items()}] if self._waiting else []


def _order_metadata(path: Path) -> None:
    """Zarr lists members in the order in which the file system and its threads return them."""
    document = json.loads(path.read_text(encoding="utf-8"))
    consolidated = document["consolidated_metadata"]
    consolidated["metadata"] = dict(sorted(consolidated["metadata"].items()))
    path.write_text(json.dumps(document, separators=(",", ":")), encoding="utf-8")

"""The files of a store are those that zarr-python writes, byte by byte."""

from pathlib import Path

import numpy as np
import pytest
import zarr
from zarr.codecs import ZstdCodec

from calibore.scans._layout import POINTS_VARIABLES, PROFILE_VARIABLES
from calibore.scans._store import SHORTEST_CHUNK, GrowingGroup

SIZES = {"clock": 7, "mode": 2, "lag": 0}


def written(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def random_values(variable, shape, rng):
    """Some of them missing; one variable is missing throughout, as the times of a scan without times."""
    if not variable.dtype.startswith("float"):
        return rng.integers(0, 9, shape).astype(variable.dtype)
    values = rng.normal(0, 1, shape)
    return np.where((rng.uniform(size=shape) < 0.2) | (variable.name == "time_s"), np.nan, values)


def by_zarr(folder, variables, blocks, *, growing, rows):
    group = zarr.create_group(folder, zarr_format=3, attributes={"format": "test", "title": "é"})
    for variable in variables:
        axis = variable.dimensions.index(growing) if growing in variable.dimensions else None
        whole = (
            blocks[variable.name] if axis is None else np.concatenate([b[variable.name] for b in blocks["all"]], axis)
        )
        chunk = [max(SIZES.get(d, 0), 1) for d in variable.dimensions]
        if axis is not None:
            chunk[axis] = rows if whole.ndim > 1 else max(rows, SHORTEST_CHUNK)
        array = group.create_array(
            variable.name,
            shape=whole.shape,
            chunks=tuple(chunk),
            dtype=variable.dtype,
            fill_value=float("nan") if variable.dtype.startswith("float") else 0,
            compressors=ZstdCodec(level=3),
            dimension_names=variable.dimensions,
            attributes=variable.attributes,
        )
        if whole.size:
            array[...] = whole.astype(variable.dtype)


@pytest.mark.parametrize(
    ("variables", "growing", "rows"), [(PROFILE_VARIABLES, "station", 4), (POINTS_VARIABLES, "point", SHORTEST_CHUNK)]
)
@pytest.mark.parametrize("lengths", [(1,), (3, 1, 9), (4, 4), (0, 5), (5000, 1, 4000)])
def test_the_files_are_those_of_zarr(tmp_path, variables, growing, rows, lengths):
    rng = np.random.default_rng(len(lengths))
    clock = np.linspace(0, 6, SIZES["clock"])
    ours = GrowingGroup(
        tmp_path / "ours",
        variables,
        growing=growing,
        rows=rows,
        sizes=SIZES,
        attributes={"format": "test", "title": "é"},
    )
    blocks = []
    for length in lengths:
        sizes = SIZES | {growing: length}
        growing_ones = [v for v in variables if growing in v.dimensions]
        blocks.append({v.name: random_values(v, tuple(sizes[d] for d in v.dimensions), rng) for v in growing_ones})
        ours.append(blocks[-1])
    if growing == "station":
        ours.fill("clock", clock)
    ours.close()
    by_zarr(tmp_path / "zarr", variables, {"all": blocks, "clock": clock}, growing=growing, rows=rows)
    expected, found = written(tmp_path / "zarr"), written(tmp_path / "ours")
    assert found.keys() == expected.keys()
    assert [name for name in found if name != "zarr.json" and found[name] != expected[name]] == []
    opened = zarr.open_consolidated(tmp_path / "ours")
    assert dict(opened.attrs) == {"format": "test", "title": "é"}
    assert sorted(opened.array_keys()) == sorted(v.name for v in variables)

"""A result in other programs' formats, copied chunk by chunk; a file appears under its name only when complete."""

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from calibore.errors import InputError, OutputError
from calibore.scans import _point_clouds
from calibore.scans._layout import POINTS_VARIABLES, STATIONS_PER_CHUNK
from calibore.scans._lock import locked
from calibore.scans._results import damage_told, open_group
from calibore.scans._staging import EXPORT_NAMES, told_as_output_error
from calibore.units import parse_quantity


def export(out: Path | str, format: str, destination: Path | str, *, length_unit: str = "m") -> Path:
    """Write the result folder `out` as `format` to the file `destination` and return its path.

    `text3`: the dissertation's three columns (Swanbom 2007, 6.3.5 and 7.5.6), tab-separated without a heading: axial,
    clock [rad], radius of every measured point of the profile grid, missing points left out; its file was in inches,
    so `length_unit="in"` reproduces it. `csv`: every column of every point. `netcdf`: the profile, CF conventions.
    `ply`, `las`, `laz`: the points that have a position, with `u_radius` and `status`. SI units but for `length_unit`,
    which only `text3` knows. Raises InputError (no such format, no result, optional package missing), OutputError.
    """
    out, destination = Path(out), Path(os.path.realpath(destination))
    check_format(format)
    if length_unit != "m" and format != "text3":
        raise InputError(
            f'Export format "{format}" is always in metres, got length_unit "{length_unit}"; leave it out.'
        )
    scale = parse_quantity(f"1 {length_unit}", "length")
    store, write = _WRITERS[format]
    group = open_group(out, store)
    if destination.exists() and not destination.is_file():  # a device would be replaced
        raise OutputError(f"{destination} cannot be written: it is no file; give the name of a new one.")
    with told_as_output_error(destination), damage_told(out / f"{store}.zarr"):
        destination.parent.mkdir(parents=True, exist_ok=True)
        with locked(destination):
            _write_aside(destination, lambda partial: write(group, partial, scale))
    return destination


def check_format(format: str) -> None:
    """Raises InputError, naming all of them, unless `format` is one that `export` knows."""
    if format not in _WRITERS:
        raise InputError(f'Export format "{format}" is not known; allowed: {", ".join(sorted(_WRITERS))}.')


def default_export_name(format: str) -> str:
    """The file name an export has inside a result folder, e.g. "points.ply"; raises InputError as `check_format`."""
    check_format(format)
    return EXPORT_NAMES[format]


def _write_aside(destination: Path, write: Callable[[Path], None]) -> None:
    # The lock makes this name ours: what lies there was left by a killed run and is written over.
    partial = destination.with_name(f".{destination.name}.partial")
    try:
        write(partial)
        os.replace(partial, destination)
    finally:
        with suppress(FileNotFoundError):
            partial.unlink()


def _write_text3(group: Any, path: Path, scale: float) -> None:
    clock = group["clock"][:]
    with path.open("w", encoding="ascii", newline="") as file:
        for rows in _slices(group["radius"].shape[0], STATIONS_PER_CHUNK):
            radius, axial = group["radius"][rows], group["axial_position"][rows]
            measured = np.isfinite(radius)
            angle = np.broadcast_to(clock, radius.shape)[measured]
            columns = np.column_stack((axial[measured] / scale, angle, radius[measured] / scale))
            np.savetxt(file, columns, fmt="%.9f", delimiter="\t")


def _write_csv(group: Any, path: Path, scale: float) -> None:
    names = [variable.name for variable in POINTS_VARIABLES]
    digits = {"float64": "%r", "float32": "%.9g"}  # both give every bit back
    formats = ",".join(digits.get(variable.dtype, "%d") for variable in POINTS_VARIABLES) + "\n"
    with path.open("w", encoding="ascii", newline="") as file:
        file.write(",".join(names) + "\n")
        for block in _point_clouds.blocks(group, names):
            file.writelines(formats % row for row in zip(*(block[name].tolist() for name in names), strict=True))


def _write_netcdf(group: Any, path: Path, scale: float) -> None:
    _point_clouds.optional_package("h5py", "netcdf")  # h5netcdf imports without it, and fails later
    h5netcdf = _point_clouds.optional_package("h5netcdf", "netcdf")
    with h5netcdf.File(path, "w") as file:
        file.attrs.update(dict(group.attrs))
        arrays = {name: group[name] for name in sorted(group.array_keys())}
        sizes = {
            d: n for array in arrays.values() for d, n in zip(array.metadata.dimension_names, array.shape, strict=True)
        }
        file.dimensions = sizes
        for name, array in arrays.items():
            _copy_to_netcdf(file, name, array)


def _copy_to_netcdf(file: Any, name: str, array: Any) -> None:
    dimensions = array.metadata.dimension_names
    packing = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if array.size else {}
    fill = np.nan if array.dtype.kind == "f" else None
    variable = file.create_variable(name, dimensions, array.dtype, fillvalue=fill, **packing)
    for key, value in array.attrs.items():
        variable.attrs[key] = np.asarray(value, dtype=array.dtype) if key == "flag_values" else value
    axis = dimensions.index("station") if "station" in dimensions else 0
    for rows in _slices(array.shape[axis], STATIONS_PER_CHUNK):
        part = (slice(None),) * axis + (rows,)
        if array.size:
            variable[part + (slice(None),) * (array.ndim - axis - 1)] = array[part]


def _slices(length: int, step: int) -> Iterator[slice]:
    return (slice(start, min(start + step, length)) for start in range(0, length, step))


_WRITERS: dict[str, tuple[str, Callable[[Any, Path, float], None]]] = {
    "text3": ("profile", _write_text3),
    "csv": ("points", _write_csv),
    "netcdf": ("profile", _write_netcdf),
    "ply": ("points", _point_clouds.write_ply),
    "las": ("points", _point_clouds.write_las),
    "laz": ("points", _point_clouds.write_laz),
}

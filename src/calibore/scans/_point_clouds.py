"""Point clouds for other programs: PLY, LAS, LAZ; the pipe frame, metres, uncertainty and status beside each point."""

import importlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore import __version__
from calibore.errors import InputError
from calibore.scans._layout import POINTS_PER_CHUNK

# LAS stores int32 multiples of a scale: 1 um reaches 4 km of pipe, far beyond one survey.
LAS_SCALE = 1e-6
_LAS_REACH = 2.0**32 - 2.0**20
_LAS_EXTRA = (
    ("u_radius", "float32", "std. uncertainty of radius [m]"),
    ("radius", "float32", "from the rig axis [m]"),
    ("clock", "float32", "from crown, clockwise [rad]"),
    ("status", "uint8", "why suspect, 0 = measured"),
    ("station", "int32", "station number"),
)
_PLY_NAMES = {"<f8": "double", "<f4": "float", "<i4": "int", "u1": "uchar"}
_PLY_PROPERTIES = (
    ("x", "<f8"),
    ("y", "<f8"),
    ("z", "<f8"),
    ("u_radius", "<f4"),
    ("radius", "<f4"),
    ("clock", "<f4"),
    ("station", "<i4"),
    ("status", "u1"),
)

Block = dict[str, NDArray[Any]]


def blocks(group: Any, names: Sequence[str]) -> Iterator[Block]:
    """The columns `names` of points.zarr, one chunk of points after the other."""
    length = group["x"].shape[0]
    for start in range(0, length, POINTS_PER_CHUNK):
        yield {name: group[name][start : start + POINTS_PER_CHUNK] for name in names}


def write_ply(group: Any, path: Path, _: float = 1.0) -> None:
    """Binary little-endian PLY."""
    count = _extent(group)[0]
    with path.open("wb") as file:
        file.write(_ply_header(count))
        for block in _placed(group, [name for name, _ in _PLY_PROPERTIES]):
            vertices = np.empty(block["x"].size, dtype=list(_PLY_PROPERTIES))
            for name, _kind in _PLY_PROPERTIES:
                vertices[name] = block[name]
            file.write(vertices.tobytes())


def write_las(group: Any, path: Path, _: float = 1.0) -> None:
    """LAS 1.4, point format 6, with extra dimensions."""
    _write_las(group, path, compress=False)


def write_laz(group: Any, path: Path, _: float = 1.0) -> None:
    """The same, compressed."""
    optional_package("lazrs", "laz")
    _write_las(group, path, compress=True)


def optional_package(name: str, format: str) -> Any:
    """Import `name`, or raise InputError saying what to install."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError(
            f'Export format "{format}" needs the package {name}; install it with: pip install "calibore[export]".'
        ) from error


def _write_las(group: Any, path: Path, *, compress: bool) -> None:
    laspy = optional_package("laspy", "laz" if compress else "las")
    low, high = _extent(group)[1:]
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.creation_date = None
    header.generating_software = f"calibore {__version__}"
    header.add_extra_dims([laspy.ExtraBytesParams(name, kind, text) for name, kind, text in _LAS_EXTRA])
    header.scales, header.offsets = _las_grid(low, high)
    names = ["x", "y", "z", *(name for name, _, _ in _LAS_EXTRA)]
    with laspy.open(path, mode="w", header=header, do_compress=compress) as file:
        for block in _placed(group, names):
            if block["x"].size:
                record = laspy.ScaleAwarePointRecord.zeros(block["x"].size, header=header)
                for name in names:
                    record[name] = block[name]
                file.write_points(record)


def _las_grid(low: NDArray[Any], high: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Scales and offsets; a pipe longer than int32 micrometres gets a ten times coarser axis."""
    decades = np.maximum(np.ceil(np.log10(np.maximum(high - low, 1.0) / (LAS_SCALE * _LAS_REACH))), 0)
    return LAS_SCALE * 10.0**decades, np.round((low + high) / 2)


def _ply_header(count: int) -> bytes:
    properties = [f"property {_PLY_NAMES[kind]} {name}" for name, kind in _PLY_PROPERTIES]
    comments = [f"comment calibore {__version__}: pipe frame, x right, y down, z along travel, metres and radians"]
    lines = ["ply", "format binary_little_endian 1.0", *comments, f"element vertex {count}", *properties, "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _placed(group: Any, names: Sequence[str]) -> Iterator[Block]:
    """`blocks` without the points that have no position: no point cloud format knows them."""
    for block in blocks(group, names):
        placed = np.isfinite(block["x"]) & np.isfinite(block["y"]) & np.isfinite(block["z"])
        yield {name: values[placed] for name, values in block.items()}


def _extent(group: Any) -> tuple[int, NDArray[Any], NDArray[Any]]:
    """Number, least and greatest coordinates of the points that have a position."""
    count, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
    for block in _placed(group, ("x", "y", "z")):
        points = np.stack([block[name] for name in ("x", "y", "z")]).astype(float)
        if points.size:
            count, low, high = count + points.shape[1], np.minimum(low, points.min(1)), np.maximum(high, points.max(1))
    return (count, low, high) if count else (0, np.zeros(3), np.zeros(3))

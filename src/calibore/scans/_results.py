"""Opening what `ResultWriter` wrote."""

import csv
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibore.errors import CaliboreError, InputError

if TYPE_CHECKING:
    import xarray


LONGEST_REASON = 160
"""Characters of what a codec says."""


def open_profile(out: Path | str) -> "xarray.Dataset":
    """The gridded profile of the result folder `out`, dims (station, clock), read lazily; raises InputError."""
    return _open(Path(out), "profile")


def open_points(out: Path | str) -> "xarray.Dataset":
    """The ungridded points of the result folder `out`, dim `point`, read lazily; raises InputError."""
    return _open(Path(out), "points")


def read_rings(out: Path | str) -> dict[str, np.ndarray]:
    """The columns of rings.csv: int64, float64 or text, each of shape (stations,); raises InputError."""
    path = part_of(Path(out), "rings.csv")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
            return {name: _column(cells) for name, *cells in zip(header, *rows, strict=True)}
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read ({error}); run the profile again.") from error


def part_of(out: Path, name: str) -> Path:
    """The path of one part of a result folder; raises InputError where `out` is no result folder."""
    if not out.is_dir():
        raise InputError(f"{out} is not a folder; give the result folder that `calibore profile` wrote.")
    if not (out / name).exists():
        raise InputError(f"{out} is not a result folder (it has no {name}); give one that `calibore profile` wrote.")
    return out / name


def open_group(out: Path, name: str) -> Any:
    """The Zarr group `name`.zarr of a result folder, its format checked; raises InputError."""
    import zarr

    path = part_of(out, f"{name}.zarr")
    with damage_told(path):
        group = zarr.open_group(path, mode="r")
    found = group.attrs.get("format")
    if found != f"calibore-{name}/1":
        raise InputError(
            f'{path} has the format {found!r}; this version reads "calibore-{name}/1": '
            "use the version of this program that wrote it, or run the profile again."
        )
    return group


@contextmanager
def damage_told(path: Path) -> Iterator[None]:
    """Whatever zarr, xarray and the codecs raise on a damaged store becomes one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a codec that is not known, in words for programmers
            yield
    except CaliboreError:
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise  # of the system; zarr's own, for files that are not there, have no number
        why = " ".join(str(error).split())[:LONGEST_REASON].rstrip(".") or type(error).__name__
        raise InputError(
            f"{path} cannot be read, it is damaged ({why}); restore a copy, or run the profile again."
        ) from error


def _open(out: Path, name: str) -> "xarray.Dataset":
    import xarray

    open_group(out, name)
    with damage_told(out / f"{name}.zarr"):
        return xarray.open_zarr(out / f"{name}.zarr", chunks=None, consolidated=True)


def _column(cells: list[str]) -> np.ndarray:
    for kind in (np.int64, np.float64):
        with suppress(ValueError, OverflowError):
            return np.array([kind(cell) for cell in cells], dtype=kind)
    return np.array(cells, dtype=str)

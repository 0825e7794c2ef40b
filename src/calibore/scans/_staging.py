"""Results are made in a hidden sibling folder and renamed when complete; what a killed run left is put in order.

Every function but `check_destination` expects its caller to hold the lock of `out`: then no leftover belongs to a
living run.
"""

import errno
import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from calibore.errors import OutputError

RESULT_FORMAT = "calibore-result/1"
SUMMARY = "summary.json"
EXPORT_NAMES = {
    "text3": "profile.txt",
    "csv": "points.csv",
    "netcdf": "profile.nc",
    "ply": "points.ply",
    "las": "points.las",
    "laz": "points.laz",
}
"""Names that exports have inside a result folder, by format."""
_LEFT_BY_FILE_BROWSERS = (".DS_Store", "Thumbs.db", "desktop.ini")
_ZARR_FILE = re.compile(r"(\w+/)?zarr\.json|\w+/c(/\d+)*")
_DISK_FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))


def is_disk_full(error: BaseException | None) -> bool:
    """Whether the disk, a quota or a file size limit ended the writing."""
    return isinstance(error, OSError) and error.errno in _DISK_FULL


@contextmanager
def told_as_output_error(out: Path) -> Iterator[None]:
    """Turn an OSError of writing into an OutputError that says what to do."""
    try:
        yield
    except OSError as error:
        if is_disk_full(error):
            raise OutputError(
                f"{out} cannot be written: the disk is full or a size limit is reached ({error.strerror}). "
                "Free some space or choose a folder on another disk."
            ) from error
        raise OutputError(
            f"{out} cannot be written ({error.strerror or error}); choose a folder that you may write to."
        ) from error


def check_destination(out: Path, identity: str) -> None:
    """Raise OutputError unless `out` is absent, empty, or a complete result of the scan with this `identity`."""
    if os.path.ismount(out):
        raise OutputError(f"{out} is a mount point and cannot be replaced as a whole; give a folder inside it.")
    if out.exists() and not out.is_dir():
        raise OutputError(f"{out} is a file, not a folder; choose another name for the result.")
    parent = next(folder for folder in out.parents if folder.exists())
    if not parent.is_dir():
        raise OutputError(f"{out} cannot be made because {parent} is not a folder; choose another place.")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(f"{out} cannot be written: {parent} is not writable; choose a folder that you may write to.")
    if out.exists() and any(out.iterdir()):
        _check_replaceable(out, identity)


def _check_replaceable(out: Path, identity: str) -> None:
    summary = read_summary(out)
    if summary is None:
        example = min(path.name for path in out.iterdir())
        raise OutputError(
            f'{out} holds files that are not a result of this program, for example "{example}"; '
            "choose an empty or new folder."
        )
    if summary["identity"] != identity:
        raise OutputError(
            f'{out} holds the result of another scan ("{summary.get("name", "")}"); '
            "choose another folder, or remove that result."
        )
    foreign = next(_foreign_files(out, summary["files"]), None)
    if foreign is not None:
        raise OutputError(
            f"{out} holds {foreign}, which this program did not write; move it away or choose another folder."
        )


def read_summary(out: Path) -> dict[str, Any] | None:
    """The summary of the result in `out`, or None where there is none that this program wrote."""
    with suppress(OSError, ValueError, RecursionError):
        summary = json.loads((out / SUMMARY).read_text(encoding="utf-8"))
        if isinstance(summary, dict) and {"format", "identity", "files"} <= summary.keys():
            return summary if summary["format"] == RESULT_FORMAT else None
    return None


def manifest(folder: Path) -> list[str]:
    """What `folder` holds, sorted: relative paths of files, and stores (`*.zarr`) as a whole."""
    stores = {path.name for path in folder.glob("*.zarr") if path.is_dir()}
    return sorted({path.split("/")[0] if path.split("/")[0] in stores else path for path in _files(folder)})


def _files(folder: Path) -> Iterator[str]:
    for parent, _, names in os.walk(folder):
        yield from (Path(parent, name).relative_to(folder).as_posix() for name in names)


def _foreign_files(out: Path, listed: list[str]) -> Iterator[str]:
    stores = {name for name in listed if name.endswith(".zarr")}
    known = {*listed, SUMMARY, *EXPORT_NAMES.values()}
    for path in _files(out):
        top, _, rest = path.partition("/")
        written = bool(_ZARR_FILE.fullmatch(rest)) if top in stores else path in known
        if not written and Path(path).name not in _LEFT_BY_FILE_BROWSERS:
            yield path


def new_staging(out: Path) -> Path:
    """A new empty folder beside `out`."""
    staging = _sibling(out, "partial")
    staging.mkdir()
    return staging


def publish(staging: Path, out: Path) -> None:
    """Give `staging` the name `out`; an earlier result steps aside first and is removed last."""
    aside = _sibling(out, "old")
    if out.exists() and any(out.iterdir()):
        os.rename(out, aside)
    elif out.exists():
        out.rmdir()
    os.rename(staging, out)
    _remove(aside)


def recover(out: Path) -> None:
    """Put back a result that was stepping aside when its run died; remove everything else a dead run left."""
    leftovers = re.compile(rf"\.{re.escape(out.name)}\.(partial|old)-\d+-[0-9a-f]{{8}}")
    for path in sorted(out.parent.iterdir()):
        found = leftovers.fullmatch(path.name)
        if found is None:
            continue
        if found[1] == "old" and _is_free(out) and _is_complete(path):
            with suppress(FileNotFoundError):
                out.rmdir()
            os.rename(path, out)
        else:
            _remove(path)


def _sibling(out: Path, kind: str) -> Path:
    return out.with_name(f".{out.name}.{kind}-{os.getpid()}-{secrets.token_hex(4)}")


def _is_free(out: Path) -> bool:
    return not out.exists() or (out.is_dir() and not any(out.iterdir()))


def _is_complete(folder: Path) -> bool:
    summary = read_summary(folder)
    return summary is not None and all((folder / name).exists() for name in summary["files"])


def _remove(folder: Path) -> None:
    """The summary goes first: without it a half-removed result is never mistaken for a complete one."""
    with suppress(OSError):
        (folder / SUMMARY).unlink()
    shutil.rmtree(folder, ignore_errors=True)

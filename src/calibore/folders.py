"""Folders that appear whole: made beside their name and renamed when complete, in place of nothing but their like.

For everything small that this program writes at once; a survey's result, which takes long and may be read while another
is made, has its own rules (`calibore.scans`).
"""

import json
import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from calibore.errors import OutputError

ABANDONED = 3600.0  # s; what is left after an hour belongs to no living run

Known = Callable[[Path], set[str] | None]
"""The names of the files that an earlier run has written into a folder; None where none of this kind has."""


@contextmanager
def whole_folder(out: Path | str, known: Known, *, what: str) -> Iterator[Path]:
    """A new folder that gets the name `out` when the block ends well, in place of an earlier one; else it vanishes.

    `what` it holds ("design", "scan"), for people. Raises OutputError where `out` holds anything else, or cannot be
    written.
    """
    out = Path(os.path.abspath(out))
    try:
        _recover(out, known)
        _check(out, known, what)
        out.parent.mkdir(parents=True, exist_ok=True)
        staging = _sibling(out, "partial")
        staging.mkdir()
        try:
            yield staging
            _publish(staging, out)
        finally:
            shutil.rmtree(staging, ignore_errors=True)
    except OSError as error:
        raise OutputError(
            f"{out} cannot be written ({error.strerror or error}); choose a folder that you may write to."
        ) from error


def listed_in(marker: str, form: str) -> Known:
    """`Known` by the JSON file `marker`, whose "format" is `form` and whose "files" lists what else was written."""

    def known(folder: Path) -> set[str] | None:
        with suppress(OSError, ValueError, RecursionError):
            found = json.loads((folder / marker).read_text(encoding="utf-8"))
            if isinstance(found, dict) and found.get("format") == form and isinstance(found.get("files"), list):
                return {marker, *found["files"]}
        return None

    return known


def _check(out: Path, known: Known, what: str) -> None:
    if out.exists() and not out.is_dir():
        raise OutputError(f"{out} is a file, not a folder; choose another name for the {what}.")
    if not out.is_dir() or not any(out.iterdir()):
        return
    mine = known(out)
    foreign = sorted(path.name for path in out.iterdir() if path.name not in (mine or ()))
    if foreign:
        raise OutputError(
            f'{out} holds "{foreign[0]}", which is no {what} of this program; choose an empty or new folder.'
        )


def _publish(staging: Path, out: Path) -> None:
    aside = _sibling(out, "old")
    if out.exists():
        os.rename(out, aside)
    os.rename(staging, out)
    shutil.rmtree(aside, ignore_errors=True)


def _recover(out: Path, known: Known) -> None:
    """Put back a folder that was stepping aside when its run died, and remove what dead runs left."""
    if not out.parent.is_dir():
        return
    pattern = re.compile(rf"\.{re.escape(out.name)}\.(partial|old)-[0-9a-f]{{8}}")
    for path in sorted(out.parent.iterdir()):
        found = pattern.fullmatch(path.name)
        if found and found[1] == "old" and not out.exists() and known(path):
            os.rename(path, out)
        elif found and time.time() - path.stat().st_mtime > ABANDONED:
            shutil.rmtree(path, ignore_errors=True)


def _sibling(out: Path, kind: str) -> Path:
    return out.with_name(f".{out.name}.{kind}-{secrets.token_hex(4)}")

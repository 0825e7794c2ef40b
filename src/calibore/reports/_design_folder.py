"""A design's folder appears whole: made beside its name and renamed when complete."""

import json
import os
import re
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from calibore.design import FORMAT
from calibore.errors import OutputError

MARKER = "design.json"
ABANDONED = 3600.0  # s; a design takes seconds, so what is left after an hour belongs to no living run


@contextmanager
def whole_folder(out: Path, *, marker: str = MARKER, form: str = FORMAT) -> Iterator[Path]:
    """A new folder that gets the name `out` when the block ends well, in place of an earlier design; else it vanishes.

    `marker`: the JSON file that tells a design, by its "format" = `form` and the "files" it lists.

    Raises OutputError where `out` holds anything that is no design of this program, or cannot be written.
    """
    out = Path(os.path.abspath(out))
    try:
        _recover(out, marker, form)
        _check(out, marker, form)
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


def read_marker(folder: Path, marker: str = MARKER, form: str = FORMAT) -> dict[str, Any] | None:
    """The `marker` in `folder`, or None where there is none that this program wrote."""
    with suppress(OSError, ValueError):
        found = json.loads((folder / marker).read_text(encoding="utf-8"))
        if isinstance(found, dict) and found.get("format") == form and isinstance(found.get("files"), list):
            return found
    return None


def _check(out: Path, marker: str, form: str) -> None:
    if out.exists() and not out.is_dir():
        raise OutputError(f"{out} is a file, not a folder; choose another name for the design.")
    if not out.is_dir() or not any(out.iterdir()):
        return
    mine = read_marker(out, marker, form)
    known = {marker, *(mine["files"] if mine else ())}
    foreign = sorted(path.name for path in out.iterdir() if path.name not in known)
    if mine is None or foreign:
        example = foreign[0] if foreign else marker
        raise OutputError(
            f'{out} holds "{example}", which is no design of this program; choose an empty or new folder.'
        )


def _publish(staging: Path, out: Path) -> None:
    aside = _sibling(out, "old")
    if out.exists():
        os.rename(out, aside)
    os.rename(staging, out)
    shutil.rmtree(aside, ignore_errors=True)


def _recover(out: Path, marker: str, form: str) -> None:
    """Put back a design that was stepping aside when its run died, and remove what dead runs left."""
    if not out.parent.is_dir():
        return
    pattern = re.compile(rf"\.{re.escape(out.name)}\.(partial|old)-[0-9a-f]{{8}}")
    for path in sorted(out.parent.iterdir()):
        found = pattern.fullmatch(path.name)
        if found and found[1] == "old" and not out.exists() and read_marker(path, marker, form):
            os.rename(path, out)
        elif found and time.time() - path.stat().st_mtime > ABANDONED:
            shutil.rmtree(path, ignore_errors=True)


def _sibling(out: Path, kind: str) -> Path:
    return out.with_name(f".{out.name}.{kind}-{secrets.token_hex(4)}")

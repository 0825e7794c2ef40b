"""Pictures of a folder into an archive, one at a time; what an interrupted run has written is not done again."""

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from calibore.crews import in_order
from calibore.errors import InputError, OutputError
from calibore.images._archive_metadata import Contents, Key, write_metadata
from calibore.images._archived_picture import DamagedError, Form, check, packed, unpacked
from calibore.images._folder import ImageFolder
from calibore.images._reading import ImageFileError, read_image

JOURNAL = "import.jsonl"
Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class Imported:
    """One line of the journal: picture `number` was the file `name` of `size` bytes with that `sha256`, and is one of
    `form`, `stored` in so many bytes; or was refused for the `reason`.
    """

    number: int
    name: str
    size: int
    sha256: str
    form: str = ""
    stored: int = 0
    reason: str = ""


@dataclass(frozen=True)
class _Item:
    """A picture to convert, and what an earlier run says of it."""

    number: int
    path: Path
    name: str
    earlier: Imported | None


def write_archive(
    source: ImageFolder, store: Path, *, journal: Path, workers: int, progress: Progress | None = None
) -> list[Imported]:
    """The pictures of `source` as the Zarr group `store`; `journal` tells a later run how far this one came.

    Every picture is decoded again and compared before it counts. Raises InputError where none is usable.
    """
    keys, names = list(source.paths), [path.relative_to(source.folder).as_posix() for path in source.paths.values()]
    earlier = _continued(journal, names, store)
    items = [
        _Item(number, path, names[number], earlier.get(number)) for number, path in enumerate(source.paths.values())
    ]
    done: list[Imported] = []
    with journal.open("a", encoding="utf-8") as file:
        for entry in in_order(items, partial(_imported, store=store, limit=source.limit), workers=workers):
            if entry != earlier.get(entry.number):
                file.write(_line(entry))
                file.flush()
            done.append(entry)
            if progress:
                progress(len(done), len(items))
    if not any(entry.form for entry in done):
        raise InputError(f"None of the {len(done)} images is usable; the first: {names[0]}: {done[0].reason}.")
    write_metadata(store, _contents(keys, done))
    _replace(journal, _header(names) + "".join(map(_line, done)).encode())
    return done


def _contents(keys: list[Key], done: list[Imported]) -> Contents:
    reasons = {entry.number: entry.reason for entry in done if not entry.form}
    return Contents(keys, [Form.named(entry.form) for entry in done], reasons)


def _imported(item: _Item, *, store: Path, limit: int) -> Imported:
    size, sha256 = _fingerprint(item.path)
    before = item.earlier
    if before and before.form and (before.size, before.sha256) == (size, sha256) and _stands(before, store):
        return before
    if before and (form := Form.named(before.form)):
        form.file(store, item.number).unlink(missing_ok=True)
    try:
        pixels = read_image(item.path, limit=limit)
    except ImageFileError as error:
        return Imported(item.number, item.name, size, sha256, reason=error.reason)
    form, data = Form.of(pixels), packed(pixels)
    if not np.array_equal(unpacked(data, form), pixels):
        raise OutputError(f"{item.path} did not survive its compression on this machine; check its memory.")
    _replace(form.file(store, item.number), data)
    return Imported(item.number, item.name, size, sha256, form.name, len(data))


def _stands(entry: Imported, store: Path) -> bool:
    """Whether the file of an earlier run is there and whole."""
    form = Form.named(entry.form)
    assert form is not None
    with suppress(OSError, DamagedError):
        check(form.file(store, entry.number).read_bytes(), form)
        return True
    return False


def _fingerprint(path: Path) -> tuple[int, str]:
    """Size and SHA-256; of a file that cannot be read nothing, it is refused when it is decoded."""
    with suppress(OSError), path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return file.tell(), digest
    return 0, ""


def _replace(path: Path, data: bytes) -> None:
    """`data` under the name `path`, whole or not at all, and on the disk: its source may be deleted next."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.partial")
    with partial.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


def _header(names: list[str]) -> bytes:
    digest = hashlib.sha256("\n".join(names).encode("utf-8", "surrogateescape")).hexdigest()
    return f"{json.dumps({'format': 'calibore-import/1', 'pictures': len(names), 'names': digest})}\n".encode()


def _line(entry: Imported) -> str:
    return f"{json.dumps(asdict(entry))}\n"


def _continued(journal: Path, names: list[str], store: Path) -> dict[int, Imported]:
    """What an earlier run of the same pictures has done, by number; a journal of others is begun anew."""
    found, whole = {}, _header(names)
    with suppress(OSError):
        lines = journal.read_bytes().splitlines(keepends=True)
        if lines and lines[0] == whole:
            for line in lines[1:]:
                try:
                    entry = Imported(**json.loads(line))
                except (ValueError, TypeError, RecursionError):
                    break  # the run died while it wrote this line
                found[entry.number], whole = entry, whole + line
        else:
            shutil.rmtree(store, ignore_errors=True)
    _replace(journal, whole)
    return found

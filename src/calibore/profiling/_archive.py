"""A scan folder made into one that keeps its pictures in an archive, everything else that scan.toml names beside it."""

import json
import os
import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from calibore.errors import InputError, OutputError
from calibore.images import JOURNAL, ImageFolder, Imported, write_archive
from calibore.profiling._measured import Progress
from calibore.scans import ScanSpec, locked, read_scan

STORE = "images.zarr"
PLACES = (
    ("[images]\n", f'[images]\narchive = "{STORE}"\n'),
    ("[images]\r\n", f'[images]\r\narchive = "{STORE}"\r\n'),
    ("images = {", f'images = {{ archive = "{STORE}",'),
    ("images.pattern", f'images.archive = "{STORE}"\nimages.pattern'),
)
"""Ways to write the table of pictures, and each with the archive in it."""


def archive_scan(
    scan: Path | str, out: Path | str, *, workers: int | None = None, progress: Progress | None = None
) -> dict[str, Any]:
    """Import the pictures of `scan` into the new folder `out`, lossless; returns what was done.

    `calibore profile` takes `out` as it takes `scan`, with the same result. A run that dies leaves its work beside
    `out` and a later one goes on there; `out` appears when everything is in. `"refused"` names the pictures that could
    not be used. Raises InputError for a scan without pictures, OutputError where `out` exists or cannot be written.
    """
    out, toml = Path(os.path.abspath(out)), Path(scan) / "scan.toml" if Path(scan).is_dir() else Path(scan)
    spec = read_scan(toml)
    _check_importable(spec, toml)
    source, text, copies = ImageFolder(spec.folder, spec.pattern or ""), *_moved(toml, spec.folder)
    with _writing(out), locked(out):
        _check_free(out)
        staging = out.with_name(f".{out.name}.importing")
        staging.mkdir(exist_ok=True)
        options: dict[str, Any] = {"workers": workers or os.cpu_count() or 1, "progress": progress}
        try:
            done = write_archive(source, staging / STORE, journal=staging / JOURNAL, **options)
        except InputError:
            shutil.rmtree(staging, ignore_errors=True)
            raise
        _copy(copies, staging)
        (staging / "scan.toml").write_bytes(text.encode())
        if out.exists():
            out.rmdir()
        os.rename(staging, out)
    return _told(out, done)


def _copy(files: dict[str, Path], folder: Path) -> None:
    for name, path in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            shutil.copytree(path, folder / name, dirs_exist_ok=True)
        else:
            shutil.copyfile(path, folder / name)


def _told(out: Path, done: list[Imported]) -> dict[str, Any]:
    usable = [entry for entry in done if entry.form]
    return {
        "archive": str(out),
        "counts": {"images": len(usable), "refused_images": len(done) - len(usable)},
        "bytes_of_files": sum(entry.size for entry in usable),
        "bytes_in_archive": sum(entry.stored for entry in usable),
        "forms": sorted({entry.form for entry in usable}),
        "refused": [{"image": entry.name, "reason": entry.reason} for entry in done if not entry.form],
    }


def _check_importable(spec: ScanSpec, toml: Path) -> None:
    if spec.archive is not None:
        raise InputError(f"{toml} names an archive already; profile it as it is.")
    if spec.pattern is None:
        what = "a film, which decoded would need many times its size" if spec.video else "no pictures"
        raise InputError(f"{toml} names {what}; only pictures (images.pattern) are imported, profile it as it is.")


@contextmanager
def _writing(out: Path) -> Iterator[None]:
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise OutputError(
            f"{out} cannot be written ({error.strerror or error}); free some space or choose another folder. "
            "Run again, and it goes on from here."
        ) from error


def _check_free(out: Path) -> None:
    """An archive is never replaced: the pictures it was made from may be gone."""
    if out.is_dir() and (out / STORE).is_dir():
        raise OutputError(f"{out} holds an archive already, which is never replaced; choose another folder.")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputError(f"{out} exists and is not empty; choose a new folder for the archive.")


def _moved(toml: Path, folder: Path) -> tuple[str, dict[str, Path]]:
    """scan.toml as it reads beside the archive, and the files to copy there by their names in it."""
    text = toml.read_bytes().decode("utf-8-sig")
    wanted, copies = tomllib.loads(text), {}
    for table, key in ((wanted, "rig"), (wanted["motion"], "table")):
        if key not in table:
            continue
        said, path = table[key], folder / table[key]
        inside = path.resolve().is_relative_to(folder) and not Path(said).is_absolute()
        table[key] = name = said if inside else path.name
        copies[name] = path
        copies |= _evidence(path, Path(name).parent) if key == "rig" else {}
        for quoted in (json.dumps(said), f"'{said}'"):
            text = text.replace(quoted, json.dumps(name)) if said != name else text
    wanted["images"]["archive"] = STORE
    for old, new in PLACES:
        if old in text and _parsed(rewritten := text.replace(old, new, 1)) == wanted:
            return rewritten, copies
    raise InputError(
        f'{toml}: no place was found for the archive; write the pictures as a table, "[images]", and rig and '
        "motion.table as plain text in quotes."
    )


def _evidence(rig: Path, folder: Path) -> dict[str, Path]:
    """What a calibrated rig file refers to, if it is there."""
    said = tomllib.loads(rig.read_text(encoding="utf-8-sig")).get("calibration", {}).get("evidence")
    path = rig.parent / said if isinstance(said, str) else None
    return {str(folder / path.name): path} if path and path.exists() and path.name == said else {}


def _parsed(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None

"""A calibration's FILE and its evidence: written so that there is the old pair, the new pair or none; read again."""

import os
import re
import secrets
import shutil
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._evidence import DIGITS, evidence_hash, read_evidence, write_evidence
from calibore.calibration._file._document import calibration_of, read_table
from calibore.calibration._file._text import file_text
from calibore.calibration._input_files import hash_of_file
from calibore.errors import InputError, OutputError

ABANDONED = 3600.0
"""s; what is left after an hour belongs to no living run."""
STORE = re.compile(rf"(.*)-([0-9a-f]{{{DIGITS}}})\.zarr")
"""Name of the evidence: FILE's stem, then the hash of its content."""


def write_calibration(calibration: Calibration, out: Path | str) -> None:
    """Write FILE `out`, a rig file or the part of one, and beside it its evidence, OUT-HASH.zarr.

    The evidence stands before FILE gets its name, and that of a replaced FILE is removed after. Raises InputError
    where the calibration contradicts itself, OutputError where `out` cannot be written; then all is as it was.
    """
    out = Path(os.path.abspath(out))
    name = f"{out.stem}-{evidence_hash(calibration.observations)}.zarr"
    text = file_text(calibration, evidence=name)
    check_calibration_file(out)
    with _told_as_output_error(out):
        out.parent.mkdir(parents=True, exist_ok=True)
        before = _evidence_named_in(out)
        placed = _place_evidence(calibration.observations, out.with_name(name))
        try:
            _place_text(text, out)
        except BaseException:
            if placed:
                shutil.rmtree(out.with_name(name), ignore_errors=True)
            raise
        _tidy(out, replaced=before if before != name else None)


def check_calibration_file(out: Path | str) -> None:
    """Raise OutputError unless `out` may be written: absent in a place that can be made, or an earlier calibration."""
    out = Path(os.path.abspath(out))
    if out.is_dir():
        raise OutputError(f'{out} is a folder; give the name of a file, e.g. "{out / "lens.toml"}".')
    parent = next(folder for folder in out.parents if folder.exists())
    if not parent.is_dir():
        raise OutputError(f"{out} cannot be made because {parent} is not a folder; choose another place.")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise OutputError(f"{out} cannot be written: {parent} is not writable; choose a folder that you may write to.")
    if out.exists() and _evidence_named_in(out) is None:
        raise OutputError(f"{out} is no calibration that this program wrote; choose another name, or move it away.")


def read_calibration(path: Path | str) -> Calibration:
    """What `write_calibration` wrote. Without its evidence beside it, FILE still says what was found: then there are no
    observations, and a warning says so. Raises InputError where FILE or evidence is not what was written.
    """
    path = Path(path)
    table = read_table(path)
    folder = path.with_name(Path(table.calibration.evidence).name)
    if not folder.is_dir():
        calibration = calibration_of(path, table, _no_observations())
        missing = (
            f"{folder.name}, the evidence of {path.name}, is not beside it: residuals cannot be shown nor checked."
        )
        return replace(calibration, warnings=(*calibration.warnings, missing))
    observations = read_evidence(folder)
    named = STORE.fullmatch(folder.name)
    if named and named[2] != evidence_hash(observations):
        raise InputError(f"{folder} has been changed since it was written; put back what `calibore calibrate` wrote.")
    return calibration_of(path, table, observations)


def verify_inputs(path: Path | str, folder: Path | str) -> dict[str, str]:
    """Which inputs of the calibration FILE `path`, looked for in `folder`, are not what it was made from: "changed" or
    "missing", by name; empty where all are.
    """
    found = {}
    for file in read_table(Path(path)).calibration.file:
        source = Path(folder) / file.name
        if not source.is_file():
            found[file.name] = "missing"
        elif hash_of_file(source) != file.sha256:
            found[file.name] = "changed"
    return found


def _evidence_named_in(path: Path) -> str | None:
    """The store that a FILE of this program names; None where it is none."""
    with suppress(OSError, ValueError):
        table = tomllib.loads(path.read_text(encoding="utf-8")).get("calibration")
        if isinstance(table, dict) and str(table.get("created_by", "")).startswith("calibore "):
            return str(table.get("evidence", ""))
    return None


def _place_evidence(observations: Observations, store: Path) -> bool:
    """Whether `store` had to be written: evidence of the same name is the same, unless it was damaged."""
    with suppress(InputError):
        if store.is_dir() and evidence_hash(read_evidence(store)) == evidence_hash(observations):
            return False
    staging = _beside(store)
    try:
        write_evidence(observations, staging)
        if store.exists():
            os.rename(store, aside := _beside(store))
            shutil.rmtree(aside, ignore_errors=True)
        os.rename(staging, store)
    finally:
        shutil.rmtree(staging, ignore_errors=True)
    return True


def _place_text(text: str, out: Path) -> None:
    staging = _beside(out)
    try:
        staging.write_text(text, encoding="utf-8")
        os.replace(staging, out)
    finally:
        staging.unlink(missing_ok=True)


def _tidy(out: Path, *, replaced: str | None) -> None:
    """Remove the evidence of the `replaced` FILE, unless a copy of that still names it, and what dead runs left."""
    others = "\n".join(path.read_text("utf-8", "replace") for path in out.parent.glob("*.toml") if path.is_file())
    for path in sorted(out.parent.iterdir()):
        named = STORE.fullmatch(path.name)
        abandoned = time.time() - path.stat().st_mtime > ABANDONED
        mine = bool(named and named[1] == out.stem and path.is_dir()) and (path.name == replaced or abandoned)
        partial = re.match(rf"\.{re.escape(out.stem)}[.-].*\.partial-[0-9a-f]{{8}}$", path.name) and abandoned
        if partial or (mine and path.name not in others):
            shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.partial-{secrets.token_hex(4)}")


@contextmanager
def _told_as_output_error(out: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"{out} cannot be written ({error.strerror or error}); choose a folder that you may write to, with space."
        ) from error


def _no_observations() -> Observations:
    none, whole = np.zeros(0), np.zeros(0, dtype=np.intp)
    return Observations(whole, none, none, none, none, none, whole, np.zeros((0, 0)), ())

"""Which kind of target calibrates what."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import ConfigDict

from calibore.calibration._calibration import Calibration
from calibore.calibration._input_files import input_file
from calibore.documents import Document, read_document
from calibore.errors import InputError

Progress = Callable[[int, int], None]
TARGET = "target.toml"
BOARD = ("lens", "_boards._calibrate", "calibrate_boards")
KINDS: dict[str, tuple[str, str, str]] = {
    "concentric-rings": ("lens", "_rings._calibrate", "calibrate_rings"),
    "chessboard": BOARD,
    "charuco": BOARD,
    "circle-grid": BOARD,
    "asymmetric-circle-grid": BOARD,
    "range": ("rig", "_rig._range", "calibrate_range"),
    "ring-gauge": ("rig", "_rig._gauges", "calibrate_gauges"),
    "two-pin": ("pupil", "_pupil._calibrate", "calibrate_pupil"),
    "probe": ("probe", "_probe._calibrate", "calibrate_probe"),
    "profile": ("profile", "_in_situ._calibrate", "calibrate_profile"),
}
"""By kind of target: the word after `calibore calibrate`, module and function, imported when they are needed."""


def calibrate(verb: str, path: Path | str, *, progress: Progress | None = None) -> Calibration:
    """What the target at `path` (target.toml or its folder) tells of a `verb`: lens, rig, pupil, probe or profile.

    Raises InputError where the target is of another kind, or does not tell enough.
    """
    path, kind = target_of(path)
    asked, module, function = KINDS[kind]
    if asked != verb:
        raise InputError(f"{path} is of kind {kind}: use `calibore calibrate {asked}`.")
    calibrated = getattr(import_module(f"calibore.calibration.{module}"), function)
    found: Calibration = calibrated(path, progress=progress)
    if any(file.name == path.name for file in found.files):
        return found
    return replace(found, files=(*found.files, input_file(path)))


def target_of(path: Path | str) -> tuple[Path, str]:
    """The target.toml at `path` and its kind; raises InputError where there is none."""
    path = Path(path)
    if path.is_dir():
        path = path / TARGET
        if not path.is_file():
            raise InputError(
                f"{path.parent} holds no {TARGET}; write one that says what was photographed, beside the pictures."
            )
    kind = read_document(path, _Heading).kind
    if kind not in KINDS:
        raise InputError(f'{path}: key kind = "{kind}" is not known; allowed: {", ".join(KINDS)}.')
    return path, kind


class _Heading(Document):
    model_config = ConfigDict(extra="ignore")

    format: Any = None
    kind: str

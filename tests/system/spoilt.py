"""Spoiling a scan, and what a refusal must say."""

import re
from pathlib import Path

import numpy as np
from command_line import Outcome, stray_files
from PIL import Image

DONE, UNUSABLE, WRONG_USAGE, PARTLY = 0, 1, 2, 3
PICTURE = "pipe {:03d} 0.png"


def images(scan: Path) -> list[Path]:
    return sorted(scan.glob("*.png"))


def replace(path: Path, pixels: np.ndarray | bytes) -> None:
    """Another picture, or any bytes, under the name of this one (which may be a link)."""
    path.unlink()
    if isinstance(pixels, bytes):
        path.write_bytes(pixels)
    else:
        Image.fromarray(pixels).save(path)


def write_key(path: Path, pattern: str, replacement: str) -> None:
    text, count = re.subn(pattern, lambda _: replacement, path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert count == 1
    path.write_text(text, encoding="utf-8")


def refused(outcome: Outcome, *words: str, status: int = UNUSABLE) -> str:
    """The command failed with `status` and one sentence that contains all `words`."""
    assert outcome.status == status, outcome
    for word in words:
        assert word in outcome.sentence
    assert outcome.sentence.endswith(".")
    return outcome.sentence


def nothing_was_written(scan: Path) -> bool:
    return not (scan.parent / "out").exists() and not stray_files(scan.parent / "out")

"""A scan folder that appears when it is complete, and replaces nothing but an earlier simulation."""

import os
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from calibore.errors import OutputError

TRUTH = "truth.npz"


def check_replaceable(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file, not a folder; choose another name for the scan.")
    if not folder.exists() or not any(folder.iterdir()):
        return
    try:
        with np.load(folder / TRUTH, allow_pickle=False) as truth:
            known = set(truth["files"].tolist())
        foreign = sorted({path.name for path in folder.iterdir()} - known)
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        foreign = ["files"]
    if foreign:
        raise OutputError(f"{folder} holds {foreign[0]} that no simulation wrote; choose an empty or new folder.")


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """A hidden sibling folder that becomes `folder` when all went well, and vanishes otherwise."""
    staging = folder.with_name(f".{folder.name}.partial-{os.getpid()}")
    try:
        staging.mkdir(parents=True)
        yield staging
        if folder.exists():
            shutil.rmtree(folder)
        staging.rename(folder)
    except OSError as error:
        raise OutputError(
            f"{folder} cannot be written ({error.strerror or error}); choose a folder that you may write to."
        ) from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)

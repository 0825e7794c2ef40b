"""The files a calibration was made from, and why some of them were not used."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

PART = 1 << 20


@dataclass(frozen=True)
class InputFile:
    """A file that was looked at: `name`, its `sha256`, and why it was not used, "" where it was: `refused` because
    something is wrong with it, or `set_aside` because it is not needed, such as a take with room light.
    """

    name: str
    sha256: str
    refused: str = ""
    set_aside: str = ""

    @property
    def used(self) -> bool:
        return not (self.refused or self.set_aside)


def input_file(path: Path, *, folder: Path | None = None, refused: str = "", set_aside: str = "") -> InputFile:
    """`path`, named from `folder` on where it is given, with the hash of its bytes, "" where it cannot be read."""
    try:
        digest = hash_of_file(path)
    except OSError:
        digest = ""
    return InputFile(path.relative_to(folder).as_posix() if folder else path.name, digest, refused, set_aside)


def hash_of_file(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    found = hashlib.sha256()
    with path.open("rb") as file:
        while part := file.read(PART):
            found.update(part)
    return found.hexdigest()

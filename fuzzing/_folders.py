"""Entries that read files: a folder that is good, one or two of its files changed, and its readers."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from fuzzing._mutations import mutated

GONE = 0.02
"""Share of files that are not there at all, or are folders."""


@dataclass
class OfFolders:
    """`seeds(folder)` makes good folders in a folder; each of `readers` reads one; files of `spoilt` (globs) change."""

    seeds: Callable[[Path], None]
    readers: tuple[Callable[[Path], object], ...]
    spoilt: tuple[str, ...] = ("*.toml",)
    _folders: dict[Path, dict[Path, bytes]] = field(default_factory=dict)

    def prepare(self, scratch: Path) -> None:
        """Make the seeds in `scratch`, once; every one of them is read."""
        home = scratch / "seeds"
        if not home.is_dir():
            (scratch / "making").mkdir(parents=True)
            self.seeds(scratch / "making")
            (scratch / "making").rename(home)
        for folder in sorted(home.iterdir()):
            paths = {path for glob in self.spoilt for path in folder.rglob(glob) if path.is_file()}
            self._folders[folder] = {path.relative_to(folder): path.read_bytes() for path in sorted(paths)}

    def attempt(self, rng: np.random.Generator, scratch: Path) -> list[Callable[[], object]]:
        """Calls to judge; their files lie in scratch/case until the next ones."""
        folders = list(self._folders)
        folder = folders[rng.integers(len(folders))]
        files, case = self._folders[folder], scratch / "case"
        shutil.rmtree(case, ignore_errors=True)
        shutil.copytree(folder, case)
        names = list(files)
        for _ in range(1 + (rng.random() < 0.1)):
            name = names[rng.integers(len(names))]
            self._spoil(case / name, files[name], rng)
        return [partial(read, case) for read in self.readers]

    def _spoil(self, path: Path, data: bytes, rng: np.random.Generator) -> None:
        if rng.random() < GONE:
            path.unlink(missing_ok=True)
            if rng.random() < 0.5:
                path.mkdir(exist_ok=True)
            return
        alike = [one for files in self._folders.values() for name, one in files.items() if name.suffix == path.suffix]
        if path.is_file():
            path.write_bytes(mutated(path.name, data, rng, others=alike))

"""A folder of image files whose names carry the station, the angular stop and the take."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from pathlib import Path

from calibore.errors import ImageError, InputError
from calibore.images._pattern import NamePattern
from calibore.images._reading import LIMIT, read_image
from calibore.images._source import PictureFile, Pixels, Refusal, StationImages

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm")


@dataclass(frozen=True)
class ImageFolder:
    """The images in `folder` whose names match `pattern`, e.g. `"plane12in {station:03d} {take}.png"`.

    Sub-folders are written with "/". Only names are read here: an image that is not there is not listed, one that is
    unusable raises ImageError when read. Raises InputError for an unusable pattern or folder, or where nothing matches.
    """

    folder: Path
    pattern: str
    limit: int = LIMIT
    paths: dict[tuple[int, int, int], Path] = field(init=False, repr=False, compare=False)
    """(station, angular, take) -> file, in that order."""

    def __post_init__(self) -> None:
        pattern = NamePattern(self.pattern)
        try:
            found = {tuple(numbers.values()): path for path, numbers in _matches(self.folder, pattern)}
        except OSError as error:
            raise InputError(
                f'Image folder "{self.folder}" cannot be read ({error.strerror}); name an existing folder.'
            ) from error
        if not found:
            raise InputError(_nothing_matches(self.folder, self.pattern))
        object.__setattr__(self, "paths", dict(sorted(found.items())))

    @property
    def expected_stations(self) -> int:
        return len({key[:2] for key in self.paths})

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """Always empty: a folder lists every image, and `read` says what is wrong with one."""
        return ()

    def stations(self) -> Iterator[StationImages]:
        """One entry per station (and angular stop), sorted."""
        for (station, angular), keys in groupby(self.paths, key=lambda key: key[:2]):
            paths = {key[2]: self.paths[key] for key in keys}
            names = tuple(path.relative_to(self.folder).as_posix() for path in paths.values())
            # other machines are sent the files of this station, not of all
            read = partial(_read_one, paths, limit=self.limit)
            files = tuple(PictureFile(path, self.limit) for path in paths.values())
            yield StationImages(station, tuple(paths), read, angular=angular, names=names, files=files)

    def read(self, station: int, take: int = 0, *, angular: int = 0) -> Pixels:
        """The pixels of one image; raises ImageError naming the file and why."""
        try:
            path = self.paths[station, angular, take]
        except KeyError:
            raise ImageError(f'There is no image of station {station}, take {take} in "{self.folder}".') from None
        return read_image(path, limit=self.limit)


def _read_one(paths: dict[int, Path], take: int, *, limit: int) -> Pixels:
    return read_image(paths[take], limit=limit)


def names_in(folder: Path, pattern: NamePattern) -> Iterator[str]:
    """Names of everything in `folder` that `pattern` may match, sub-folders before "/"; raises OSError."""
    yield from _names(folder, pattern.folders, "")


def _matches(folder: Path, pattern: NamePattern) -> Iterator[tuple[Path, dict[str, int]]]:
    for name in names_in(folder, pattern):
        numbers = pattern.match(name)
        if numbers is not None and (path := folder / name).is_file():
            yield path, numbers


def _names(folder: Path, parts: tuple[re.Pattern[str] | str, ...], before: str) -> Iterator[str]:
    """Names below `folder`, as deep as the pattern goes and only where it can match."""
    here = folder / before
    if not parts:
        yield from (before + name for name in os.listdir(here))
        return
    names = [parts[0]] if isinstance(parts[0], str) else [name for name in os.listdir(here) if parts[0].fullmatch(name)]
    for name in names:
        if (here / name).is_dir():
            yield from _names(folder, parts[1:], f"{before}{name}/")


def _nothing_matches(folder: Path, pattern: str) -> str:
    files = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    if not files:
        return f'Image folder "{folder}" is empty: no file matches "{pattern}"; copy the images there.'
    images = [name for name in files if name.lower().endswith(SUFFIXES)] or files
    there = "1 file" if len(files) == 1 else f"{len(files)} files"
    return (
        f'No image in "{folder}" matches "{pattern}": there are {there}, for example "{images[0]}". '
        "Write the pattern as the files are named; fields: {station}, {angular}, {take}, e.g. {station:03d} for 007."
    )

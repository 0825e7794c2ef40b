"""Pictures of one stop: which of them show the laser alone, and their mean."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._input_files import InputFile, input_file
from calibore.errors import ImageError, InputError
from calibore.images import read_image

Picture = NDArray[np.uint16]
LIT, TIMES = 0.03, 3.0
"""A picture has room light where its typical brightness exceeds that of the darkest take of its stop by this fraction
of white and is this many times as high."""
BRIGHT = 0.2
"""A picture whose typical brightness exceeds this fraction of white is no picture of a laser line in the dark."""
ROOM_LIGHT, NO_OTHER = "it has room light", "and no other take shows the laser alone"
EIGHT_BITS = 257
"""From 8 bits to 16."""


@dataclass(frozen=True, eq=False)
class Takes:
    """The mean `picture` (h, w[, 3]) of the takes of one stop that show the laser alone, None where there is none;
    their `files`, used or not: room light is no fault where another take shows the laser alone; the numbers of the
    `used` takes and of those with room light, `lit`.
    """

    picture: Picture | None
    files: tuple[InputFile, ...]
    used: tuple[int, ...]
    lit: tuple[int, ...]


def average_takes(paths: dict[int, Path], *, folder: Path, size: "OneSize") -> Takes:
    """Averages the pictures of one stop, by number of the take; what takes share, such as speckle, is then seen in
    the mean as it is.
    """
    pictures, why = {}, {}
    for take, path in paths.items():
        try:
            pictures[take] = size.checked(read_image(path), path)
        except ImageError as error:
            why[take] = str(error)
    levels = {take: _level(picture) for take, picture in pictures.items()}
    lowest = min(levels.values(), default=0.0)
    lit = [take for take, level in levels.items() if level > max(TIMES * lowest, lowest + LIT) or level > BRIGHT]
    used = tuple(take for take in pictures if take not in lit)
    if not used:
        why |= {take: f"{ROOM_LIGHT} (typically {levels[take]:.0%} of white), {NO_OTHER}" for take in lit}
    aside = {take: ROOM_LIGHT for take in lit if used}
    files = tuple(
        input_file(path, folder=folder, refused=why.get(take, ""), set_aside=aside.get(take, ""))
        for take, path in paths.items()
    )
    return Takes(_mean([pictures[take] for take in used]) if used else None, files, used, tuple(lit))


@dataclass
class OneSize:
    """All pictures of a calibration are of one size [px]: that of the camera, where it is `known`, or of the first."""

    known: tuple[int, int] | None = None
    of: str = "the rig's camera"

    def checked(self, picture: NDArray[Any], path: Path) -> NDArray[Any]:
        size = picture.shape[1], picture.shape[0]
        if self.known is None:
            self.known, self.of = size, f'"{path.name}"'
        if size != self.known:
            raise InputError(
                f'Picture "{path.name}" is {size[0]} x {size[1]} px, {self.of} {self.known[0]} x {self.known[1]} px; '
                "a calibration holds for one camera with one setting: take all pictures with it, at full size."
            )
        return picture


def _level(picture: NDArray[Any]) -> float:
    """Typical brightness as a fraction of white."""
    white = 2 ** (8 * picture.dtype.itemsize) - 1
    return float(np.median(picture)) / white


def _mean(pictures: list[NDArray[Any]]) -> Picture:
    total = np.zeros(pictures[0].shape)
    for picture in pictures:
        total += picture.astype(float) * (EIGHT_BITS if picture.dtype == np.uint8 else 1)
    return np.rint(total / len(pictures)).astype(np.uint16)


Progress = Callable[[int, int], None]

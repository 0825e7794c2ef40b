"""target.toml of a concentric-ring target, and its photographs turned into marks."""

import re
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, Strict

from calibore.calibration._in_words import Unit
from calibore.calibration._input_files import InputFile, input_file
from calibore.documents import Document, FileName, Length, read_document
from calibore.errors import ImageError, InputError
from calibore.images import ImageFolder, read_image
from calibore.optics import LENS_NAMES
from calibore.targets import RingMarks, find_rings

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

FEWEST_RINGS = 4
"""Three rings always agree with k, D and one more parameter: the fourth is the first that can contradict."""
Pixel = Annotated[float, Strict()]
Positive = Annotated[Length, Field(gt=0)]


def _known_law(law: str) -> str:
    if law not in LENS_NAMES:
        raise ValueError(f"it is not known; allowed: {', '.join(LENS_NAMES)}")
    return law


class RingTargetFile(Document):
    """[m], [px]. `u_ring`: standard uncertainty of each printed radius, left out where the pictures shall tell; `lens`:
    the law where it is known; `principal_point` roughly, where it is not near the image's middle.
    """

    format: Literal["calibore-target/1"]
    kind: Literal["concentric-rings"]
    images: Annotated[FileName, Field(min_length=1)]
    ring_spacing: Positive
    rings: Annotated[int, Strict(), Field(ge=FEWEST_RINGS, le=1000)]
    spokes: Annotated[int, Strict(), Field(ge=2, le=360)]
    nominal_baseline: Positive
    ink_width: Positive | None = None
    u_ring: Annotated[Length, Field(ge=0)] | None = None
    u_baseline: Positive | None = None
    lens: Annotated[str, AfterValidator(_known_law)] | None = None
    principal_point: tuple[Pixel, Pixel] | None = None
    square_pixels: Annotated[bool, Strict()] = False


@dataclass(frozen=True, eq=False)
class RingPictures:
    """What target.toml says and its photographs show: `marks` of those that could be used, numbered in `used` among
    all `files`; image `size` (width, height) [px]; the `unit` of length of whoever wrote it.
    """

    toml: Path
    target: RingTargetFile
    marks: tuple[RingMarks, ...]
    used: tuple[int, ...]
    files: tuple[InputFile, ...]
    size: tuple[int, int]
    unit: Unit

    @property
    def radii(self) -> Array:
        """Printed radii [m], innermost first."""
        return self.target.ring_spacing * np.arange(1.0, self.target.rings + 1)


def read_ring_pictures(path: Path | str, *, progress: Progress | None = None) -> RingPictures:
    """Marks of every photograph on which the target is found; the others are listed with the reason. Raises InputError
    where target.toml is wrong, none is left, or their sizes differ.
    """
    path = Path(path)
    toml = path / "target.toml" if path.is_dir() else path
    target = read_document(toml, RingTargetFile)
    if target.ink_width is not None and target.ink_width >= target.ring_spacing:
        raise InputError(f"{toml}: ink_width must be less than ring_spacing, or the rings touch; measure a line.")
    photographs = _photographs(toml, target.images)
    files, found, sizes = [], [], {}
    for number, file in enumerate(photographs):
        try:
            image = read_image(file)
            found.append((number, _marks(image, target)))
            sizes.setdefault((image.shape[1], image.shape[0]), file.name)
            files.append(input_file(file))
        except ImageError as error:
            files.append(input_file(file, refused=str(error)))
        if progress is not None:
            progress(number + 1, len(photographs))
    if not found:
        raise InputError(f"{toml}: no photograph shows the target. {files[0].name}: {files[0].refused}")
    _check_sizes(toml, sizes)
    used, marks = zip(*found, strict=True)
    unit = Unit.of_length(tomllib.loads(toml.read_text(encoding="utf-8"))["ring_spacing"])
    return RingPictures(toml, target, marks, used, tuple(files), next(iter(sizes)), unit)


def _marks(image: NDArray[np.uint8 | np.uint16], target: RingTargetFile) -> RingMarks:
    marks = find_rings(image, rings=target.rings, spokes=target.spokes)
    rings = np.unique(marks.ring[marks.ring > 0]).size
    if rings < FEWEST_RINGS:
        raise ImageError(
            f"only {rings} rings are found, {FEWEST_RINGS} are needed; photograph the target so that more of its "
            f"{target.rings} rings are in the picture, sharp and evenly lit."
        )
    return marks


def _check_sizes(toml: Path, sizes: dict[tuple[int, int], str]) -> None:
    if len(sizes) > 1:
        (first, name), (second, other) = list(sizes.items())[:2]
        raise InputError(
            f"{toml}: {name} is {first[0]} x {first[1]} px, but {other} is {second[0]} x {second[1]} px; all "
            "photographs must come from one camera at one setting."
        )


def _photographs(toml: Path, pattern: str) -> list[Path]:
    """Files that `pattern` names: with the fields {station} and {take}, with * and ?, or one name."""
    files = sorted(_matching(toml.parent, pattern))
    if not files:
        raise InputError(
            f'{toml}: images = "{pattern}" matches no file in {toml.parent}; write the name of the photograph, or a '
            "pattern with {station} or {take} where names are numbered."
        )
    return files


def _matching(folder: Path, pattern: str) -> Iterator[Path]:
    if "{" in pattern:
        named = pattern if "{station" in pattern else pattern.replace("{take", "{station", 1)
        try:
            return iter(ImageFolder(folder, named).paths.values())
        except InputError as error:
            raise InputError(str(error).replace(f'"{named}"', f'"{pattern}"')) from error
    if re.search(r"[*?\[]", pattern):
        return (path for path in folder.glob(pattern) if path.is_file())
    return (path for path in [folder / pattern] if path.is_file())

"""target.toml of a flat board, and its photographs turned into marks."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Strict, Tag, model_validator

from calibore.calibration._input_files import InputFile, input_file
from calibore.documents import UNNAMED, Document, FileName, Length, read_document
from calibore.errors import ImageError, InputError
from calibore.images import read_image
from calibore.optics import LENS_NAMES
from calibore.targets import Board, BoardMarks, find_board

Progress = Callable[[int, int], None]

WORKERS = 4
FUZZY = 2.0
"""Times the median blur, above which a picture is not sharp enough to stand beside the others."""
SHARP = 1.3  # px; a picture of less blur is never refused for it
Positive = Annotated[Length, Field(gt=0)]
Count = Annotated[int, Strict(), Field(gt=0, le=100)]
Glob = Annotated[FileName, Field(min_length=1)]
Globs = Annotated[
    Annotated[Glob, Tag(UNNAMED + "name")] | Annotated[tuple[Glob, ...], Tag(UNNAMED + "names")],
    Discriminator(lambda value: UNNAMED + ("names" if isinstance(value, list | tuple) else "name")),
]


def _known_law(law: str) -> str:
    if law not in LENS_NAMES:
        raise ValueError(f"it is not known; allowed: {', '.join(LENS_NAMES)}")
    return law


class BoardTargetFile(Document):
    """[m]. `corners` (or dots) along rows and columns, inner ones; or `squares`, one more each. `square`: a square, or
    the pitch of dots (of an asymmetric grid: from row to row); `dot`: their diameter; `flatness`: how far the board may
    be off its plane, 0 for a flat one, left out where unknown; `lens`: the law where it is known.
    """

    format: Literal["calibore-target/1"]
    kind: Literal["chessboard", "charuco", "circle-grid", "asymmetric-circle-grid"]
    images: Globs
    square: Positive
    corners: tuple[Count, Count] | None = None
    squares: tuple[Count, Count] | None = None
    marker: Positive | None = None
    dictionary: str = "4x4_50"
    dot: Positive | None = None
    flatness: Annotated[Length, Field(ge=0)] | None = None
    lens: Annotated[str, AfterValidator(_known_law)] | None = None

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.corners is None) == (self.squares is None):
            raise ValueError("give corners = [columns, rows] of inner corners (or dots), or squares = [columns, rows]")
        if self.squares is not None and self.kind.endswith("circle-grid"):
            raise ValueError("squares belong to a chessboard or ChArUco board; count the dots as corners")
        if self.kind == "charuco" and self.marker is None:
            raise ValueError('a ChArUco board needs marker = "..", the side of its markers')
        return self

    @property
    def board(self) -> Board:
        """Raises InputError for a board that cannot be."""
        columns, rows = self.corners or self.squares or (0, 0)
        less = 0 if self.corners else 1
        marker = self.marker / self.square if self.marker else 0.75
        dot = self.dot / self.square if self.dot else 0.5
        return Board(self.kind, (columns - less, rows - less), marker, self.dictionary, dot)


@dataclass(frozen=True, eq=False)
class BoardPictures:
    """What target.toml says and its photographs show: `marks` of those that could be used, numbered in `used` among
    all `files`; image `size` (width, height) [px].
    """

    toml: Path
    target: BoardTargetFile
    marks: tuple[BoardMarks, ...]
    used: tuple[int, ...]
    files: tuple[InputFile, ...]
    size: tuple[int, int]


def read_board_pictures(path: Path, *, progress: Progress | None = None) -> BoardPictures:
    """Marks of every photograph on which the board is found sharp; the others are listed with the reason. Raises
    InputError where target.toml is wrong, none is left, or their sizes differ.
    """
    toml = path / "target.toml" if path.is_dir() else path
    target = read_document(toml, BoardTargetFile)
    try:
        board = target.board
    except InputError as error:
        raise InputError(f"{toml}: {error}") from error
    photographs = _photographs(toml, target)
    found, sizes = _looked_at(photographs, board, progress)
    _check_sizes(toml, sizes)
    found = _sharp_ones(found)
    refusals = [marks if isinstance(marks, str) else "" for marks in found]
    files = tuple(input_file(file, refused=why) for file, why in zip(photographs, refusals, strict=True))
    if all(refusals):
        raise InputError(f"{toml}: no photograph shows the board. {files[0].name}: {files[0].refused}")
    used = tuple(number for number, why in enumerate(refusals) if not why)
    good = tuple(marks for marks in found if isinstance(marks, BoardMarks))
    return BoardPictures(toml, target, good, used, files, next(iter(sizes)))


def _looked_at(
    photographs: Sequence[Path], board: Board, progress: Progress | None
) -> tuple[list[BoardMarks | str], dict[tuple[int, int], Path]]:
    """Marks of each, or why there are none; the sizes that occur, with the first file of each."""
    found: list[BoardMarks | str] = []
    sizes: dict[tuple[int, int], Path] = {}
    with ThreadPoolExecutor(min(WORKERS, os.cpu_count() or 1)) as workers:
        results = workers.map(lambda file: _seen(file, board), photographs)
        for file, (marks, size) in zip(photographs, results, strict=True):
            found.append(marks)
            if size is not None:
                sizes.setdefault(size, file)
            if progress is not None:
                progress(len(found), len(photographs))
    return found, sizes


def _seen(file: Path, board: Board) -> tuple[BoardMarks | str, tuple[int, int] | None]:
    """Marks, or why there are none; the picture's size where it can be read."""
    size = None
    try:
        image = read_image(file)
        size = image.shape[1], image.shape[0]
        marks = find_board(
            image,
            kind=board.kind,
            corners=board.corners,
            marker=board.marker,
            dictionary=board.dictionary,
            dot=board.dot,
        )
    except ImageError as error:
        return str(error), size
    return marks, size


def _sharp_ones(found: list[BoardMarks | str]) -> list[BoardMarks | str]:
    """Blurred pictures replaced by the reason for refusing them."""
    blurs = [marks.blur for marks in found if isinstance(marks, BoardMarks)]
    usual = float(np.median(blurs)) if blurs else np.inf
    limit = max(FUZZY * usual, SHARP)
    return [
        f"blurred: its edges are {marks.blur:.1f} px wide (standard deviation), those of the others {usual:.1f} px; "
        "hold camera and board still, in focus."
        if isinstance(marks, BoardMarks) and marks.blur > limit
        else marks
        for marks in found
    ]


def _check_sizes(toml: Path, sizes: dict[tuple[int, int], Path]) -> None:
    if len(sizes) > 1:
        (first, file), (second, other) = list(sizes.items())[:2]
        raise InputError(
            f"{toml}: {file.name} is {first[0]} x {first[1]} px, but {other.name} is {second[0]} x {second[1]} px; all "
            "photographs must come from one camera at one setting."
        )


def _photographs(toml: Path, target: BoardTargetFile) -> list[Path]:
    patterns = (target.images,) if isinstance(target.images, str) else target.images
    files = sorted({file for pattern in patterns for file in _matching(toml.parent, pattern)})
    if not files:
        raise InputError(
            f'{toml}: images = "{", ".join(patterns)}" matches no file in {toml.parent}; write a pattern such as '
            '"*.png".'
        )
    return files


def _matching(folder: Path, pattern: str) -> list[Path]:
    try:
        return [file for file in folder.glob(pattern) if file.is_file()]
    except (ValueError, NotImplementedError) as error:
        raise InputError(
            f'images = "{pattern}" is no pattern of files ({error}); write it relative to target.toml, such as "*.png".'
        ) from error

"""target.toml of the two-pin fixture, and its pictures turned into sightings of the pins."""

import string
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from calibore.calibration._in_words import Unit
from calibore.calibration._input_files import InputFile, input_file
from calibore.calibration._pupil._model import Sightings
from calibore.documents import Angle, Document, FileName, Length, filled, read_document
from calibore.errors import ImageError, InputError
from calibore.images import read_image
from calibore.optics import LENS_LAWS
from calibore.targets import find_pins
from calibore.units import parse_quantity

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
DEFAULT_U_SLIDE = 0.0005 * 0.0254
"""m; a dial caliper with a depth probe, as the dissertation's (8.2.3)."""
DEFAULT_U_TURNTABLE = np.radians(0.05)
"""rad; a turntable with a vernier. Both pins shift alike, so the pupil hardly depends on it."""
ROWS = 50
"""Marks used per pin and picture: neighbouring rows are alike."""


def _known_law(law: str) -> str:
    if law not in LENS_LAWS:
        raise ValueError(f"it is not known; allowed: {', '.join(LENS_LAWS)}")
    return law


def _length(text: str) -> str:
    try:
        parse_quantity(text, "length")
    except InputError as error:
        raise ValueError(str(error)) from error
    return text


LengthText = Annotated[str, AfterValidator(_length)]
"""A length as written: its unit is the one to answer in."""


class TwoPinTarget(Document):
    """[m], [rad]. `lens` left out: the pictures tell."""

    format: Literal["calibore-target/1"]
    kind: Literal["two-pin"]
    images: FileName
    slides: Annotated[tuple[LengthText, ...], Field(min_length=1)]
    turntable: Annotated[tuple[Angle, ...], Field(min_length=1)]
    near_pin: Literal["upper", "lower"]
    far_pin: Literal["upper", "lower"]
    lens: Annotated[str, AfterValidator(_known_law)] | None = None
    u_slide: Annotated[Length, Field(gt=0)] = DEFAULT_U_SLIDE
    u_turntable: Annotated[Angle, Field(gt=0)] = float(DEFAULT_U_TURNTABLE)


@dataclass(frozen=True, eq=False)
class TwoPinPictures:
    """What target.toml says and its pictures show: readings `slides` (m,) [m], written in `unit`, `turns` [rad],
    marks `seen`, whose pictures are counted as `files` are; image size [px].
    """

    target: TwoPinTarget
    slides: Array
    unit: Unit
    turns: Array
    seen: Sightings
    files: tuple[InputFile, ...]
    width: int
    height: int


def read_two_pin(path: Path, *, progress: Progress | None = None) -> TwoPinPictures:
    """The fixture's pictures; raises InputError where the file is wrong or too few pictures show both pins."""
    toml = path / "target.toml" if path.is_dir() else path
    target = read_document(toml, TwoPinTarget)
    if target.near_pin == target.far_pin:
        raise InputError(f'{toml}: near_pin and far_pin are both "{target.near_pin}"; one is "upper", one "lower".')
    slides = np.array([parse_quantity(text, "length") for text in target.slides])
    turns = np.array(target.turntable)
    wanted = [
        (s, t, toml.parent / _name(target.images, s, t, toml)) for s in range(slides.size) for t in range(turns.size)
    ]
    files, parts, sizes = [], [], set()
    for number, (slide, turn, file) in enumerate(wanted):
        try:
            image = read_image(file)
            marks = find_pins(image, near_half=target.near_pin, far_half=target.far_pin)
        except ImageError as error:
            files.append(input_file(file, refused=str(error)))
        else:
            files.append(input_file(file))
            sizes.add((image.shape[1], image.shape[0]))
            thin = _thinned(marks.near)
            half_width = np.zeros(marks.u.size) if marks.half_width is None else marks.half_width
            columns = (marks.u, marks.v, marks.sigma, half_width, marks.near)
            count = int(np.count_nonzero(thin))
            labels = (np.full(count, number), np.full(count, slide), np.full(count, turns[turn]))
            parts.append((*(column[thin] for column in columns), *labels))
        if progress is not None:
            progress(number + 1, len(wanted))
    if not parts:
        raise InputError(f"{toml}: no picture shows both pins. The first: {files[0].name}: {files[0].refused}.")
    if len(sizes) > 1:
        raise InputError(
            f"{toml}: the pictures have different sizes; take all of them with one camera and one setting."
        )
    seen = Sightings(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    (width, height), *_ = sizes
    return TwoPinPictures(target, slides, Unit.of_length(target.slides[0]), turns, seen, tuple(files), width, height)


def _name(pattern: str, slide: int, turn: int, toml: Path) -> str:
    try:
        fields = {field for _, field, _, _ in string.Formatter().parse(pattern) if field is not None}
        if fields != {"slide", "turn"}:
            raise ValueError("it needs the fields {slide} and {turn} and no others")
        return filled(pattern, slide=slide, turn=turn)
    except (ValueError, LookupError) as error:
        raise InputError(
            f'{toml}: images = "{pattern}" is wrong: {error}. Write it as "pupil {{slide:03d}} {{turn}}.png"; slide '
            "and turn count from 0 in the lists slides and turntable."
        ) from error


def _thinned(near: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """At most ROWS marks of each pin, evenly."""
    kept = np.zeros(near.size, dtype=bool)
    for pin in (True, False):
        mine = np.flatnonzero(near == pin)
        kept[mine[:: max(1, -(-mine.size // ROWS))]] = True
    return kept

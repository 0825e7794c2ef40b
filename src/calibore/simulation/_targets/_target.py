"""A target, and the folder that comes of it."""

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.crews import Workers, in_order
from calibore.folders import whole_folder
from calibore.simulation._files import earlier_simulation, png_bytes, write_truth
from calibore.simulation._targets._toml import toml_text

Progress = Callable[[int, int], None]
Image = NDArray[np.uint8 | np.uint16]
Said = Mapping[str, Any]
"""Keys of target.toml: numbers, text (a length or an angle with its unit), lists; None leaves a key out."""

ERRORS, PICTURES = 0, 1  # streams of chance


@dataclass(frozen=True, eq=False)
class Layout:
    """What lies before the camera or on the bench, everything drawn that chance decides: the `pictures` by file name,
    each photographed with a Generator of its own; other `files` by name; what target.toml says; the `truth`, SI.
    """

    said: Said
    truth: Mapping[str, Any]
    pictures: Mapping[str, Callable[[np.random.Generator], Image]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


class Target(ABC):
    """A thing that is known, and looks at it. Every target has `stated`: keys of target.toml instead of, or beside,
    what follows from its design, e.g. {"lens": "sine-law", "u_ring": "0.02 mm"}; `verb`: what it calibrates.
    """

    stated: Said
    verb: ClassVar[str]

    @abstractmethod
    def laid_out(self, rng: np.random.Generator) -> Layout:
        """The target with the errors that `rng` draws of its making and placing."""


def simulate_target(
    folder: Path | str,
    target: Target,
    *,
    seed: int,
    workers: Workers | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write `folder` as `calibore calibrate` takes it (formats.md, section 5), with truth.npz beside it; returns it.

    The same target and seed give the same bytes. `progress(done, total)` counts pictures. The folder appears when it is
    complete; an earlier one is replaced only if it holds nothing but an earlier simulation. `workers`: None for all
    cores. Raises OutputError.
    """
    folder = Path(folder).absolute()
    crew = workers or os.cpu_count() or 1
    with whole_folder(folder, earlier_simulation, what="simulated target") as staging:
        layout = target.laid_out(np.random.default_rng([seed, ERRORS]))
        takes = list(enumerate(layout.pictures.items()))
        for done, (name, image) in enumerate(in_order(takes, partial(_taken, seed), workers=crew), start=1):
            (staging / name).write_bytes(image)
            if progress is not None:
                progress(done, len(takes))
        said = {"format": "calibore-target/1", **layout.said, **target.stated}
        for name, text in {**layout.files, "target.toml": toml_text(said)}.items():
            (staging / name).write_text(text, encoding="utf-8")
        write_truth(staging, layout.truth)
    return folder


def _taken(seed: int, item: tuple[int, tuple[str, Callable[[np.random.Generator], Image]]]) -> tuple[str, bytes]:
    number, (name, photographed) = item
    image = photographed(np.random.default_rng([seed, PICTURES, number]))
    colour = image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2)
    return name, png_bytes(colour)

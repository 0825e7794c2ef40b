"""What a specification describes: a scan with pictures, a scan by touch, or a calibration target; and its folder."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import ConfigDict

from calibore.crews import Workers
from calibore.documents import Document, read_document
from calibore.errors import InputError
from calibore.simulation._spec import read_survey
from calibore.simulation._spec_targets import read_target
from calibore.simulation._spec_touch import read_touch
from calibore.simulation._survey import Survey, simulate_scan
from calibore.simulation._tactile import TactileSurvey, simulate_tactile
from calibore.simulation._targets import Target, simulate_target

Subject = Survey | TactileSurvey | Target


class _Heading(Document):
    model_config = ConfigDict(extra="ignore")

    tactile: Any = None
    target: Any = None


def read_subject(path: Path | str, *, seed: int | None = None) -> tuple[Subject, int]:
    """What `path` specifies, and its seed, or `seed` instead; raises InputError naming file and key."""
    path = Path(path)
    heading = read_document(path, _Heading)
    if heading.tactile is not None and heading.target is not None:
        raise InputError(f"{path} gives both [tactile] and [target]; write a specification for each.")
    if heading.tactile is None and heading.target is None:
        return read_survey(path, seed=seed)
    try:
        if heading.target is not None:
            return read_target(path, seed=seed)
        touch, stated = read_touch(path)
    except InputError as error:
        raise error if str(error).startswith(str(path)) else InputError(f"{path}: {error}") from error
    return touch, stated if seed is None else seed


def simulate(
    folder: Path | str,
    subject: Subject,
    *,
    seed: int,
    workers: Workers | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """The folder of any `subject`, whole; see `simulate_scan`, `simulate_tactile`, `simulate_target`."""
    if isinstance(subject, Survey):
        return simulate_scan(folder, subject, seed=seed, workers=workers, progress=progress)
    if isinstance(subject, TactileSurvey):
        return simulate_tactile(folder, subject, seed=seed, workers=workers, progress=progress)
    return simulate_target(folder, subject, seed=seed, workers=workers, progress=progress)

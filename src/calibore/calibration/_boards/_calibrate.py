"""The lens from photographs of a flat board: chessboard, ChArUco or dots."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from calibore.calibration._boards._agreeing import agreeing_boards
from calibore.calibration._boards._coverage import coverage_warnings, valid_region
from calibore.calibration._boards._findings import findings_of, warnings_of
from calibore.calibration._boards._fit import BoardFit, fit_boards
from calibore.calibration._boards._models import Trial, board_models, comparison_table, recommended, tried_models
from calibore.calibration._boards._pictures import BoardPictures, Progress, read_board_pictures
from calibore.calibration._boards._sufficiency import (
    check_count,
    check_fit,
    check_identified,
    check_poses,
    leaning_on_law,
)
from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._evidence import of_fit
from calibore.errors import InputError
from calibore.uncertainty import Covariance


def calibrate_boards(path: Path | str, *, progress: Progress | None = None) -> Calibration:
    """`path`: target.toml or its folder. Camera with covariance, all lens models compared, evidence.

    Raises InputError where the pictures do not carry an answer: which evidence is missing, what to photograph.
    """
    steps = _Steps(progress)
    pictures = read_board_pictures(Path(path), progress=steps.looked)
    return calibration_of(pictures, done=steps.done)


class _Steps:
    """Pictures looked at, then models tried, counted together."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress, self._pictures, self._models = progress, 0, 0
        self._total = len(board_models(None))

    def looked(self, done: int, total: int) -> None:
        self._pictures = total
        if self._progress is not None:
            self._progress(done, total + self._total)

    def done(self) -> None:
        self._models += 1
        if self._progress is not None:
            self._progress(self._pictures + min(self._models, self._total), self._pictures + self._total)


def calibration_of(pictures: BoardPictures, *, done: Callable[[], None] = lambda: None) -> Calibration:
    """The same from marks already found; `done` is called after each model."""
    check_count(pictures, len(pictures.marks))
    data, starts, pictures = agreeing_boards(pictures)
    check_poses(data, min(starts, key=lambda start: start.rms), pictures)
    trials = tried_models(data, board_models(pictures.target.lens), starts, done=done)
    try:
        chosen = recommended(trials)
        check_fit(chosen)
        assert chosen.estimate is not None
        found = fit_boards(data, chosen.estimate)
    except InputError as error:
        raise InputError(f"{pictures.toml}: {error}") from error
    check_identified(found, pictures)
    return _calibration(found, pictures, trials, chosen)


def _calibration(found: BoardFit, pictures: BoardPictures, trials: list[Trial], chosen: Trial) -> Calibration:
    fit, camera, names = found.fit, found.estimate.camera, found.camera_names
    valid = valid_region(found.data, camera)
    files = pictures.files
    u, v = np.repeat(found.data.pixel, 2, axis=0).T
    table = comparison_table(trials, chosen)
    polynomials = [row for row in table if row.model.startswith("polynomial")]
    return Calibration(
        kind=pictures.target.kind,
        rig=None,
        camera=camera,
        values={name: fit.value(name) for name in names},
        covariance=Covariance(names, found.covariance, degrees_of_freedom=[_freedom(found, name) for name in names]),
        degrees_of_freedom=fit.degrees_of_freedom,
        noise=fit.noise,
        group_sigma=fit.group_sigma,
        files=files,
        observations=Observations(
            file=np.repeat(np.array(pictures.used, dtype=np.intp)[found.data.owner], 2), u=u, v=v, **of_fit(fit)
        ),
        valid=valid,
        models=table,
        findings=findings_of(found, pictures, trials, chosen, valid),
        warnings=warnings_of(
            found, files, [*leaning_on_law(found, polynomials), *coverage_warnings(found.data, camera, valid)]
        ),
    )


def _freedom(found: BoardFit, name: str) -> float:
    combination = np.zeros(len(found.fit.names))
    combination[found.fit.names.index(name)] = 1.0
    return found.fit.degrees_of_freedom_of(combination)

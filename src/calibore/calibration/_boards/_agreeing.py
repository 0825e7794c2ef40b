"""From the marks of all pictures to the data that agree with each other."""

from dataclasses import replace

import numpy as np

from calibore.calibration._boards._bundle import Estimate
from calibore.calibration._boards._data import BoardData
from calibore.calibration._boards._dot_shift import dot_shift
from calibore.calibration._boards._models import board_models
from calibore.calibration._boards._outliers import Cleaned, cleaned
from calibore.calibration._boards._pictures import BoardPictures
from calibore.calibration._boards._start import first_estimates
from calibore.calibration._boards._sufficiency import check_count
from calibore.errors import InputError

FLATNESS = 1e-3
"""Of the board's diagonal: how far an ordinary board may be off its plane where nothing is stated."""
DOT_ROUNDS = 2


def agreeing_boards(pictures: BoardPictures) -> tuple[BoardData, list[Estimate], BoardPictures]:
    """Data without the marks and pictures that contradict the others; an estimate of each law that images such boards;
    what is left, the reasons told among its files. Dots are moved to where their centres are.
    """
    law, measured = pictures.target.lens, _data(pictures)
    starts = first_estimates(measured, board_models(law))
    if not starts:
        raise InputError(f"{pictures.toml}: no lens law images boards so; check corners and square, or leave lens out.")
    data, clean = measured, cleaned(measured, starts, law)
    for _ in range(DOT_ROUNDS if pictures.target.board.has_dots else 0):
        shift = dot_shift(measured, clean.estimate, _diameter(pictures))
        data = replace(measured, pixel=measured.pixel - np.where(np.isfinite(shift), shift, 0.0))
        clean = cleaned(data, starts, law)
    boards = np.unique(data.owner[clean.used])
    left = _without(pictures, clean)
    check_count(left, boards.size)
    kept = [replace(start, poses=start.poses[boards], residual=start.residual[clean.used]) for start in starts]
    return data.only(clean.used), kept, left


def _data(pictures: BoardPictures) -> BoardData:
    target = pictures.target
    size = np.ptp(target.board.places, axis=0) * target.square
    u_bend = FLATNESS * float(np.hypot(*size)) if target.flatness is None else target.flatness / np.sqrt(3)
    return BoardData.of(pictures.marks, square=target.square, size=pictures.size, u_bend=u_bend)


def _diameter(pictures: BoardPictures) -> float:
    """Of the dots [m], as stated or as seen."""
    target = pictures.target
    return target.dot or target.square * float(np.median([marks.dot for marks in pictures.marks]))


def _without(pictures: BoardPictures, clean: Cleaned) -> BoardPictures:
    files = list(pictures.files)
    for board, reason in clean.refused.items():
        number = pictures.used[board]
        files[number] = replace(files[number], refused=reason)
    kept = [board for board in range(len(pictures.marks)) if board not in clean.refused]
    return replace(
        pictures,
        files=tuple(files),
        used=tuple(pictures.used[board] for board in kept),
        marks=tuple(pictures.marks[board] for board in kept),
    )

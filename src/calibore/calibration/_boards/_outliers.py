"""Marks and whole pictures that contradict the others."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate, bundle
from calibore.calibration._boards._data import BoardData
from calibore.calibration._boards._models import DOUBT, HIGHEST
from calibore.calibration._boards._start import started_like
from calibore.calibration._lens_models import LensModel
from calibore.errors import InputError
from calibore.optics import LENS_LAWS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MEDIAN_OF_RAYLEIGH = 1.1774  # median length of a residual whose coordinates have standard deviation 1
FAR = 6.0  # standard deviations: one in 6e7 of the marks lies farther off by chance
CONTRARY = 3.0  # times the median of the pictures' residuals: no blur or distance explains that
SPOILT = 0.3  # of the marks of a picture
MANY = 0.34  # of the pictures: then it is the model or the board that does not fit
ROUNDS = 4
LEAST_MARKS = 6


class Cleaned(NamedTuple):
    """Which marks (n,) of the data are used, why boards are not (by their number), and an estimate of what is left."""

    used: Mask
    refused: dict[int, str]
    estimate: Estimate


def cleaned(data: BoardData, starts: Sequence[Estimate], law: str | None) -> Cleaned:
    """Marks judged by the most flexible model, whose fit heeds those little that are far off."""
    used = np.ones(data.owner.size, dtype=bool)
    refused: dict[int, str] = {}
    estimate = _flexible(data, starts, law)
    for _ in range(ROUNDS):
        keep, reasons = _judged(data, used, estimate)
        if np.array_equal(keep, used):
            break
        refused |= reasons
        lost = len(refused)
        if lost > max(1, MANY * data.boards):
            raise InputError(
                f"{lost} of {data.boards} pictures contradict the others ({next(iter(refused.values())).rstrip('.')}); "
                f"{DOUBT}."
            )
        used = keep
        if np.unique(data.owner[used]).size < 2:
            break
        estimate = _refitted(data, used, estimate)
    return Cleaned(used, refused, estimate)


def _flexible(data: BoardData, starts: Sequence[Estimate], law: str | None) -> Estimate:
    """Of flexible models fitted robustly, the one with the least median residual."""
    best = min(starts, key=lambda estimate: float(np.median(estimate.square)))
    models = [HIGHEST] if law in (None, "polynomial") else []
    models += [LensModel(name, ("c1", "c2")) for name in LENS_LAWS if law in (None, name)]
    found = []
    for model in models:
        own = best if model is HIGHEST else next((start for start in starts if start.model.law == model.law), None)
        if own is None or (model is not HIGHEST and own.model.law != best.model.law and law is None):
            continue
        try:
            found.append(bundle(data, started_like(model, own), robust=True, settled=1e-7))
        except InputError:
            continue
    return min(found or [best], key=lambda estimate: float(np.median(estimate.square)))


def _refitted(data: BoardData, used: Mask, estimate: Estimate) -> Estimate:
    """Fitted to the marks in use; residuals of all, NaN of boards without any."""
    boards = np.unique(data.owner[used])
    part = data.only(used)
    start = Estimate(
        estimate.model, estimate.values, estimate.poses[boards], estimate.residual[used], data.size, estimate.bends
    )
    found = bundle(part, start, robust=True, settled=1e-7)
    poses = np.full((data.boards, 6), np.nan)
    poses[boards] = found.poses
    with np.errstate(all="ignore"):
        pixel = data.predicted(found.camera, poses, found.bends).pixel
    return Estimate(found.model, found.values, poses, data.pixel - pixel, data.size, found.bends)


def _judged(data: BoardData, used: Mask, estimate: Estimate) -> tuple[Mask, dict[int, str]]:
    """Which marks agree, and the boards that do not, each with the reason."""
    length = np.hypot(*(estimate.residual / data.sigma[:, None]).T)
    deviation = float(np.median(length[used])) / MEDIAN_OF_RAYLEIGH
    boards = np.unique(data.owner[used])
    medians = {board: float(np.median(length[used & (data.owner == board)])) for board in boards}
    usual = float(np.median(list(medians.values())))
    keep = used & (length <= FAR * max(deviation, 1e-12))
    reasons: dict[int, str] = {}
    rms = {board: float(np.sqrt(np.mean(estimate.square[used & (data.owner == board)]))) for board in boards}
    for board in boards:
        own = used & (data.owner == board)
        spoilt = 1 - keep[own].sum() / own.sum()
        if medians[board] > CONTRARY * usual or spoilt > SPOILT or keep[own].sum() < LEAST_MARKS:
            keep &= data.owner != board
            others = float(np.median([rms[other] for other in boards if other != board]))
            reasons[int(board)] = (
                f"its marks lie {rms[board]:.2f} px (rms) from where the other pictures put them, theirs {others:.2f} "
                "px; the board or the camera's setting was another one, or it was bent or wrongly found."
            )
    return keep, reasons

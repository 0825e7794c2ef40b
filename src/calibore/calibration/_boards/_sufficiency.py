"""Whether the pictures can answer at all: how many, how differently the board was held, what cannot be told apart."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate
from calibore.calibration._boards._data import BoardData, rotations
from calibore.calibration._boards._fit import POSE, BoardFit
from calibore.calibration._boards._models import DOUBT, Trial
from calibore.calibration._boards._pictures import BoardPictures
from calibore.calibration._boards._start import started_like
from calibore.calibration._calibration import Comparison
from calibore.calibration._in_words import word_of
from calibore.calibration._lens_models import CENTRE, LensModel
from calibore.errors import InputError

Array = NDArray[np.float64]

FEWEST = 4
"""Three poses determine a camera; the fourth is the first that can contradict."""
ADVICE = (
    "photograph the board 12 to 20 times, tilted by 20 to 45 deg about both of its axes, in every part of the picture"
)
SAME_TURN, SAME_PLACE = np.radians(3.0), 0.03
"""Poses that differ by less, the place as a part of the distance, tell the same."""
FREE = LensModel("polynomial", ("polynomial_3", "polynomial_5"))
ROUNDING = 1e-13  # relative: the direction that cannot be told apart shall count
PARALLEL = np.radians(3.0)
WORST_RMS = 3.0
"""px: residuals beyond which the marks are not those of this board through any lens."""
LEANING = 0.005
"""Relative standard uncertainty of k with a free polynomial, beyond which a law that makes it much less is told."""
PARTS = {"z": "distance", "x": "place", "y": "place"} | dict.fromkeys(POSE[:3], "tilt")
LOOSE_K, LOOSE_CENTRE = 0.02, 0.02
"""Relative standard uncertainty of k, and of the principal point in widths of the picture, beyond which the answer is
none: a fiftieth is what a data sheet knows."""


def check_count(pictures: BoardPictures, usable: int) -> None:
    """Raises InputError where too few pictures are left."""
    if usable >= FEWEST:
        return
    refused = [file for file in pictures.files if file.refused]
    reason = f" ({len(refused)} were refused; {refused[0].name}: {refused[0].refused.rstrip('.')})" if refused else ""
    raise InputError(
        f"{pictures.toml}: {usable} usable photographs of the board{reason}, at least {FEWEST} are needed; {ADVICE}."
    )


def check_poses(data: BoardData, estimate: Estimate, pictures: BoardPictures) -> None:
    """Raises InputError where all pictures show the board alike, or tilted alike."""
    count, distinct = len(estimate.poses), distinct_poses(estimate.poses)
    if distinct < FEWEST - 1:
        poses = "one pose" if distinct == 1 else f"{distinct} poses"
        raise InputError(
            f"{pictures.toml}: all {count} photographs show the board at {poses}, from which k, the principal point "
            f"and the board's distance cannot be told apart; {ADVICE}."
        )
    tilt = widest_tilt(estimate.poses)
    if tilt < PARALLEL:
        correlation = distance_correlation(data, estimate)
        raise InputError(
            f"{pictures.toml}: the board was held at one tilt, within {np.degrees(tilt):.1f} deg, in all {count} "
            f"photographs: k and its distance cannot be told apart (correlation {correlation:.4f}); {ADVICE}."
        )


def distance_correlation(data: BoardData, estimate: Estimate) -> float:
    """Largest correlation of k with the distance of a board, the lens being free to follow no law."""
    free = started_like(FREE, estimate)
    found = data.predicted(free.camera, free.poses, free.bends)
    shared = found.by_camera[:, :, [free.camera.parameter_names.index(name) for name in free.names]]
    jacobian = np.zeros((data.owner.size, 2, data.boards, 6))
    jacobian[np.arange(data.owner.size), :, data.owner] = found.by_pose
    rows = np.concatenate([shared, jacobian.reshape(data.owner.size, 2, -1)], axis=2).reshape(2 * data.owner.size, -1)
    _, values, turns = np.linalg.svd(rows / np.linalg.norm(rows, axis=0), full_matrices=False)
    factor = turns.T / np.maximum(values, ROUNDING * values[0])
    k, distance = factor[0], factor[len(free.names) + np.arange(5, 6 * data.boards, 6)]
    return float(np.abs(distance @ k / (np.linalg.norm(k) * np.linalg.norm(distance, axis=1))).max())


def distinct_poses(poses: Array) -> int:
    """How many of `poses` (m, 6) differ from all before."""
    kept: list[Array] = []
    for pose in poses:
        if not any(_alike(pose, other) for other in kept):
            kept.append(pose)
    return len(kept)


def _alike(pose: Array, other: Array) -> bool:
    turn = rotations(pose[None, :3])[0].T @ rotations(other[None, :3])[0]
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    apart = np.linalg.norm(pose[3:] - other[3:]) / np.linalg.norm(other[3:])
    return bool(angle < SAME_TURN and apart < SAME_PLACE)


def widest_tilt(poses: Array) -> float:
    """Largest angle [rad] between two of the boards."""
    normal = rotations(poses[:, :3])[:, :, 2]
    return float(np.arccos(np.clip((normal @ normal.T).min(), -1, 1)))


def check_identified(found: BoardFit, pictures: BoardPictures) -> None:
    """Raises InputError where k or the principal point is known too badly to be of use, naming the correlation."""
    width = found.data.size[0]
    loose = {"camera.k": found.u("camera.k") / found.fit.value("camera.k") / LOOSE_K}
    loose |= {name: found.u(name) / width / LOOSE_CENTRE for name in CENTRE}
    worst = max(loose, key=lambda name: loose[name])
    if loose[worst] <= 1:
        return
    other, correlation = _partner(found, worst)
    u, tilt = found.u(worst), np.degrees(widest_tilt(found.estimate.poses))
    known = f"known to {u:.3g} px only" if np.isfinite(u) else "not known at all"
    raise InputError(
        f"{pictures.toml}: {_said(worst)} is {known}: it cannot be told apart from {_said(other)} (correlation "
        f"{correlation:.4f}); the boards are tilted against each other by at most {tilt:.0f} deg; {ADVICE}."
    )


def check_fit(chosen: Trial) -> None:
    """Raises InputError where even the best model is none."""
    if chosen.rms > WORST_RMS:
        raise InputError(
            f"no lens model fits; the best one, {chosen.model.name}, leaves {chosen.rms:.1f} px (rms); {DOUBT}."
        )


def leaning_on_law(found: BoardFit, free: Sequence[Comparison]) -> list[str]:
    """A warning where k is only known because the lens is taken to follow its law; `free`: polynomials tried."""
    known = [row.estimates["camera.k"] for row in free if row.parameters >= len(found.camera_names) and row.estimates]
    if not known:
        return []
    loose = min(quantity.u / quantity.value for quantity in known)
    tight = found.u("camera.k") / found.fit.value("camera.k")
    if not loose > max(LEANING, 3 * tight):
        return []
    tilt = np.degrees(widest_tilt(found.estimate.poses))
    return [
        f"k rests on the lens following its law: a free polynomial would leave it uncertain by {100 * loose:.2g} %; "
        f"the boards are tilted against each other by at most {tilt:.0f} deg; {ADVICE}."
    ]


def _said(name: str) -> str:
    table, *_, key = name.split(".")
    return word_of(name) if table == "camera" else f"the {PARTS.get(key, 'bend')} of the board"


def _partner(found: BoardFit, name: str) -> tuple[str, float]:
    """The parameter that correlates most with `name`."""
    names, u = found.fit.names, found.fit.u
    index = names.index(name)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.abs(found.fit.covariance[index] / (u * u[index]))
    correlation[~np.isfinite(correlation)] = 1.0  # what is not known at all goes with whatever else is not
    correlation[index] = 0.0
    partner = int(np.argmax(correlation))
    return names[partner], float(min(correlation[partner], 1.0))

"""Whether the pictures can answer at all: how many, how differently the board was held, what cannot be told apart."""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards_bundle import Estimate
from calibore.calibration._boards_data import rotations
from calibore.calibration._boards_fit import BoardFit
from calibore.calibration._boards_pictures import BoardPictures
from calibore.calibration._lens_models import CENTRE
from calibore.errors import InputError

Array = NDArray[np.float64]

FEWEST = 4
"""Three poses determine a camera; the fourth is the first that can contradict."""
ADVICE = "photograph the board 12 to 20 times, tilted by 20 to 45 deg about both of its axes, in every part of the picture"
SAME_TURN, SAME_PLACE = np.radians(3.0), 0.03
"""Poses that differ by less, the place as a part of the distance, tell the same."""
PARALLEL = np.radians(3.0)
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


def check_poses(estimate: Estimate, pictures: BoardPictures) -> None:
    """Raises InputError where all pictures show the board alike, or parallel to each other."""
    count, distinct = len(estimate.poses), distinct_poses(estimate.poses)
    if distinct < FEWEST - 1:
        poses = "one pose" if distinct == 1 else f"{distinct} poses"
        raise InputError(
            f"{pictures.toml}: all {count} photographs show the board at {poses}, from which k, the principal point and the "
            f"board's distance cannot be told apart; {ADVICE}."
        )
    tilt = widest_tilt(estimate.poses)
    if tilt < PARALLEL:
        raise InputError(
            f"{pictures.toml}: the board is parallel to itself within {np.degrees(tilt):.1f} deg in all {count} photographs: "
            f"k and its distance cannot be told apart (correlation 1.000); {ADVICE}."
        )


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
    u = found.u(worst)
    known = f"known to {u:.3g} px only" if np.isfinite(u) else "not known at all"
    raise InputError(
        f"{pictures.toml}: {worst} is {known}: it cannot be told apart from {other} (correlation {correlation:.4f}); the boards "
        f"are tilted against each other by at most {np.degrees(widest_tilt(found.estimate.poses)):.0f} deg; {ADVICE}."
    )


def _partner(found: BoardFit, name: str) -> tuple[str, float]:
    """The parameter that correlates most with `name`."""
    names, covariance = found.fit.names, found.fit.covariance
    index = names.index(name)
    u = found.fit.u
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.abs(covariance[index] / (u * u[index]))
    correlation[index] = 0.0
    correlation = np.where(np.isfinite(correlation), correlation, 1.0) if not np.isfinite(u[index]) else correlation
    correlation[index] = 0.0
    partner = int(np.nanargmax(correlation))
    return names[partner], float(min(correlation[partner], 1.0))

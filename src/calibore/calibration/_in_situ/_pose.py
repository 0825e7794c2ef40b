"""How a reference lies in the frame of a scan, roughly, and which marks can be compared with it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._in_situ._file import ProfileTarget
from calibore.calibration._in_situ._marks import FEWEST_MARKS, Marks
from calibore.calibration._in_situ._wall import WallGrid, WallReference
from calibore.calibration._rig._looks import Look
from calibore.errors import InputError
from calibore.rigs import Rig, triangulate

Array = NDArray[np.float64]

ROLLS = 25
"""Rolls tried, within twice their standard uncertainty."""
TRIED = 2000
"""Points used to try them."""
FAR = 8.0
"""Robust standard deviations from the reference beyond which a mark is no comparison: a feature that one of both does
not show, dirt, a reflection."""
LEAST_SPREAD = 2e-5
"""m; the comparison is not taken for better than this when marks are chosen."""
SETTING = "reference"


class Aligned(NamedTuple):
    """`looks` at the reference, with `compared` of all `marks`; `off` [m]: robust scatter of their radii about it."""

    looks: tuple[Look, ...]
    compared: int
    marks: int
    off: float


def aligned(target: ProfileTarget, rig: Rig, marks: tuple[Marks, ...]) -> Aligned:
    """Looks at the reference; raises InputError where too few marks can be compared."""
    typical = float(np.nanmedian(target.wall.radius))
    points = [triangulate(rig, one.u, one.v, laser=one.laser, prior_radius=typical).points for one in marks]
    said = target.said
    u_pose = np.array([said.u_roll, np.inf, np.inf, said.u_axial, said.u_slope, said.u_slope])
    level = WallReference(target.wall, 0.0, 0.0, np.zeros(6), u_pose, target.wall.u)
    references = [replace(level, axial=one.axial, roll=one.roll) for one in marks]
    places = [one.place(found, one.pose) for one, found in zip(references, points, strict=True)]
    x, y, z = (np.concatenate(axis) for axis in zip(*places, strict=True))
    pose = _pose(target, x, y, z)
    off, kept = _compared(target, x, y, z, pose)
    rows = np.split(kept, np.cumsum([one.u.size for one in marks])[:-1])
    looks = tuple(
        _look(one, replace(reference, pose=pose), mine)
        for one, reference, mine in zip(marks, references, rows, strict=True)
        if np.count_nonzero(mine) >= FEWEST_MARKS
    )
    if not looks:
        raise InputError(
            f"{target.path}: hardly a mark of the scan falls on a sound part of the reference "
            f"({np.count_nonzero(kept)} of {kept.size}); check that both were measured in the same stretch of pipe, "
            "and their axial origins."
        )
    return Aligned(looks, int(sum(look.u.size for look in looks)), int(kept.size), off)


def _look(marks: Marks, reference: WallReference, kept: NDArray[np.bool_]) -> Look:
    u, v, direction, sigma = (getattr(marks, name)[kept] for name in ("u", "v", "direction", "sigma"))
    return Look(
        u, v, direction, sigma, reference, marks.name, laser=marks.laser, setting=SETTING, stop=SETTING, file=marks.file
    )


def _pose(target: ProfileTarget, x: Array, y: Array, z: Array) -> Array:
    """Roll and shifts (6,) that bring the scan nearest to the reference, its scale left free."""
    wall, u_roll = target.wall, target.said.u_roll
    chosen = np.flatnonzero(np.isfinite(x))
    chosen = chosen[:: max(1, chosen.size // TRIED)]
    best, pose = np.inf, np.zeros(6)
    for roll in (np.linspace(-2, 2, ROLLS) * u_roll).tolist() if not target.is_gauge else [0.0]:
        found, spread = _shift(wall, x[chosen], y[chosen], z[chosen], roll)
        cost = spread * (1 + 1e-6 * (roll / u_roll) ** 2)
        if cost < best:
            best, pose = cost, np.array([roll, found[1], found[2], 0.0, 0.0, 0.0])
    if not np.isfinite(best):
        raise InputError(
            f"{target.path}: the scan does not reach the reference; its points lie at {z.min():.4g} ... {z.max():.4g} "
            f"m, the reference at {wall.axial[0]:.4g} ... {wall.axial[-1]:.4g} m. Check motion.axial of both."
        )
    return pose


def _shift(wall: WallGrid, x: Array, y: Array, z: Array, roll: float) -> tuple[Array, float]:
    """Scale, shift in x and in y (3,) that robustly fit the scan to the reference, and the spread left."""
    c, s = np.cos(roll), np.sin(roll)
    x, y = c * x - s * y, s * x + c * y
    clock, radius = np.arctan2(x, -y), np.hypot(x, y)
    usable = wall.usable(z, clock) if wall.axial.size > 1 or not _constant(wall) else np.isfinite(radius)
    if np.count_nonzero(usable) < FEWEST_MARKS:
        return np.zeros(3), np.inf
    clock, radius = clock[usable], radius[usable]
    gap = radius - wall.radius_at(z[usable], clock)
    design = np.stack([radius, -np.sin(clock), np.cos(clock)], axis=1)
    kept, found, spread = np.ones(gap.size, dtype=bool), np.zeros(3), np.inf
    for _ in range(6):
        found = np.asarray(np.linalg.lstsq(design[kept], gap[kept], rcond=None)[0], dtype=float)
        left = np.abs(gap - design @ found)
        spread = 1.4826 * float(np.median(left))
        kept = left <= max(3 * spread, LEAST_SPREAD)
    return found, spread


def _constant(wall: WallGrid) -> bool:
    return float(np.ptp(wall.filled)) == 0.0


def _compared(target: ProfileTarget, x: Array, y: Array, z: Array, pose: Array) -> tuple[float, NDArray[np.bool_]]:
    """The spread about the reference, and which points (n,) to compare."""
    wall = target.wall
    found, spread = _shift(wall, x, y, z, float(pose[0]))
    c, s = np.cos(pose[0]), np.sin(pose[0])
    x, y = c * x - s * y, s * x + c * y
    clock, radius = np.arctan2(x, -y), np.hypot(x, y)
    known = np.isfinite(radius)
    usable = np.zeros(radius.size, dtype=bool)
    usable[known] = wall.usable(z[known], clock[known])
    gap = np.full(radius.size, np.inf)
    gap[known] = radius[known] - wall.radius_at(z[known], clock[known])
    gap[known] -= np.stack([radius, -np.sin(clock), np.cos(clock)], axis=1)[known] @ found
    return spread, usable & (np.abs(gap) <= FAR * max(spread, LEAST_SPREAD))

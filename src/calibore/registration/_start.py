"""A motion near enough to the right one: roll and axial shift are tried, centre and scale solved for each."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import clock_of
from calibore.registration._gaps import Cloud, residual_of
from calibore.registration._motion import Motion
from calibore.registration._robust import cost_of, scale_of, tukey
from calibore.registration._surface import Surface

Array = NDArray[np.float64]

ROLLS = np.radians(np.arange(-14.4, 14.5, 1.8))
"""Tried about the start: beyond 10 deg on either side, in steps of two clock positions."""
STATIONS = 2.5
"""Spacings of the coarser profile by which axial shifts are tried on either side."""
FINEST = 0.04
"""Of the radius: axial shifts nearer to each other need not be tried."""
TRIED = 1500
"""Points used to try a motion."""
BEST = 4
"""Motions kept to be refined."""
SOLVED = 4
"""Steps of reweighting for centre and scale."""
OVERLAP = 0.5
"""Of the points that lie on the reference in the best case: motions that leave fewer there are not compared."""


@dataclass(frozen=True)
class Trial:
    """A `motion`, and the mean negative log likelihood `cost` of the points on the reference, `used` of them."""

    motion: Motion
    cost: float
    used: int


def starts(cloud: Cloud, surface: Surface, start: Motion, *, spacing: float, scaled: bool) -> list[Trial]:
    """The likeliest motions about `start`, best first; none where hardly a point ever lies on the reference.

    `spacing` [m]: stations of the coarser profile; `scaled`: whether radii may differ by a factor.
    """
    few = cloud.only(np.arange(0, len(cloud.points), max(1, len(cloud.points) // TRIED)))
    step = max(spacing / 4, FINEST * surface.profile.typical_radius)
    reach = np.arange(0, STATIONS * max(spacing, 1e-9) + step / 2, step)
    shifts = np.unique(np.concatenate([-reach, reach]))
    trials = [
        trial(few, surface, replace(start, roll=start.roll + roll, axial=start.axial + shift), scaled=scaled)
        for roll in ROLLS.tolist()
        for shift in shifts.tolist()
    ]
    enough = OVERLAP * max(one.used for one in trials)
    kept = sorted((one for one in trials if one.used >= max(enough, 8)), key=lambda one: one.cost)
    return _apart(kept, step)


def trial(cloud: Cloud, surface: Surface, motion: Motion, *, scaled: bool) -> Trial:
    """`motion` with the centre, and where `scaled` the scale, that suits it best."""
    residual, variance = residual_of(cloud, surface, motion)
    used = np.isfinite(residual)
    if np.count_nonzero(used) < 8:
        return Trial(motion, np.inf, 0)
    x, y, _ = motion.apply(cloud.points[used]).T
    clock, radius = clock_of(x, y), np.hypot(x, y)
    columns = [-np.sin(clock), np.cos(clock)] + ([-radius] if scaled else [])
    design, residual, sigma = np.stack(columns, axis=1), residual[used], np.sqrt(variance[used])
    left, found, scale = residual, np.zeros(len(columns)), scale_of(residual / sigma)
    for _ in range(SOLVED):
        weight = np.sqrt(tukey(left / (scale * sigma))) / sigma
        found = np.linalg.lstsq(design * weight[:, None], -residual * weight)[0]
        left = residual + design @ found
        scale = scale_of(left / sigma)
    motion = replace(motion, shift_x=motion.shift_x + found[0], shift_y=motion.shift_y + found[1])
    if scaled:
        motion = replace(motion, scale=motion.scale * (1 + found[2]))
    return Trial(motion, cost_of(left, sigma, scale), int(np.count_nonzero(used)))


def _apart(trials: list[Trial], step: float) -> list[Trial]:
    """The best trials that are no neighbours of a better one."""
    kept: list[Trial] = []
    for one in trials:
        near = (
            abs(one.motion.roll - other.motion.roll) < 1.5 * np.radians(1.8)
            and abs(one.motion.axial - other.motion.axial) < 1.5 * step
            for other in kept
        )
        if len(kept) < BEST and not any(near):
            kept.append(one)
    return kept

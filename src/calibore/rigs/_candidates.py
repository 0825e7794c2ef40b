"""All meetings of camera rays with a laser surface, and which of them is the wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.lasers import LaserSurface, MeetingFlag
from calibore.optics import Rays, RaysWithSensitivities
from calibore.rigs._rig import Rig

EXISTS, NOWHERE = 1e6, 2e6  # above any |log of a ratio of radii|
PRIOR = 0.02
"""Cost of a ray per |log(radius / prior)|, against 1 per |log| of a jump between neighbouring rays."""
EDGE = 0.1
"""No jump costs more: edges of openings and rails are real."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """`distance` (m, n) along n rays to the m meetings of each, their `flags` (m, n), `radius` (m, n) [m] from the rig
    axis.

    NaN radius where there is no meeting ahead. Grazing ones are there: what the wall is does not depend on whether it
    can be measured.
    """

    distance: NDArray[Any]
    flags: NDArray[np.uint8]
    radius: NDArray[np.float64]

    @property
    def branches(self) -> int:
        return self.radius.shape[0]

    def distance_of(self, branch: NDArray[np.intp]) -> NDArray[Any]:
        return self.distance[branch, np.arange(branch.size)]

    def flags_of(self, branch: NDArray[np.intp]) -> NDArray[np.uint8]:
        return self.flags[branch, np.arange(branch.size)]


def meetings_of(rig: Rig, u: ArrayLike, v: ArrayLike, *, laser: int = 0) -> Candidates:
    """Every place where the rays through pixels `u`, `v` (n,) meet the surface of `laser`."""
    rays = rig.mount.place(rig.camera.unproject(np.atleast_1d(u), np.atleast_1d(v)))
    return candidates_along(rays, rig.lasers[laser].surface)


def candidates_along(rays: Rays | RaysWithSensitivities, surface: LaserSurface) -> Candidates:
    meetings = surface.meet(rays.origin, rays.direction)
    ahead = (meetings.flags != MeetingFlag.NONE) & (meetings.flags & MeetingFlag.BEHIND == 0)
    distance = np.where(ahead & np.isfinite(meetings.distance), np.real(meetings.distance), np.nan)
    points = np.real(rays.origin) + distance[..., None] * np.real(rays.direction)
    return Candidates(meetings.distance, meetings.flags, np.hypot(points[..., 0], points[..., 1]))


def nearest_branch(candidates: Candidates, prior_radius: NDArray[np.float64]) -> NDArray[np.intp]:
    """(n,) the branch whose radius is nearest to `prior_radius` [m], a number or (n,), as a ratio; where no meeting
    counts, one that at least exists.
    """
    cost = np.where(candidates.flags != MeetingFlag.NONE, EXISTS, NOWHERE)
    usable = candidates.radius > 0
    away = np.abs(np.log(np.where(usable, candidates.radius, 1.0) / prior_radius))
    return np.argmin(np.where(usable, away, cost), axis=0)


def follow_stripe(candidates: Candidates, prior_radius: float, *, closed: bool = True) -> NDArray[np.intp]:
    """(n,) the branch of every ray, rays in order along one stripe: the path that jumps least and stays nearest to
    `prior_radius` [m].

    Two branches are equally smooth, so the prior decides between whole stretches; but where it would change the branch
    for a few rays only, or a dent brings the wall nearer to the other branch, continuity holds. A jump costs no more
    than `EDGE`, so that a real edge does not bend the choice. `closed`: the last ray is beside the first.
    """
    usable = np.flatnonzero((candidates.radius > 0).any(axis=0))
    branch = nearest_branch(candidates, np.asarray(prior_radius, dtype=float))
    alone = (candidates.radius > 0).sum(axis=0) == 1
    if candidates.branches == 1 or alone[usable].all():
        return branch
    if closed and alone.any():
        usable = np.roll(usable, -int(np.flatnonzero(alone[usable])[0]))
    radius = np.where(candidates.radius[:, usable] > 0, candidates.radius[:, usable], np.inf)
    branch[usable] = _least_cost_path(np.log(radius / prior_radius))
    return branch


def _least_cost_path(level: NDArray[np.float64]) -> NDArray[np.intp]:
    """(n,) the rows of `level` (m, n), infinite where there is none, of the path that costs least (Viterbi).

    In plain numbers: the rows are few, and 1500 steps of arrays of two would take three times as long.
    """
    rows, columns = range(level.shape[0]), level.T.tolist()
    pull = (PRIOR * np.abs(level)).T.tolist()
    cost, came_from = pull[0], []
    for before, here, own in zip(columns, columns[1:], pull[1:], strict=False):
        step = [_cheapest(place, before, cost, rows) for place in here]
        came_from.append([row for _, row in step])
        cost = [total + more for (total, _), more in zip(step, own, strict=True)]
    path = np.empty(level.shape[1], dtype=np.intp)
    path[-1] = best = min(rows, key=cost.__getitem__)
    for n in range(len(came_from) - 1, -1, -1):
        path[n] = best = came_from[n][best]
    return path


def _cheapest(place: float, before: list[float], cost: list[float], rows: range) -> tuple[float, int]:
    """Cost and row of the best step to `place` from the places `before` it."""
    if place == np.inf:
        return np.inf, 0
    return min((cost[k] + min(abs(place - before[k]), EDGE) if before[k] < np.inf else np.inf, k) for k in rows)

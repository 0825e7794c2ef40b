"""Where camera rays graze a cone of light, and what is left to measure there.

Round a ring the meeting changes from the near to the far one where the camera's rays touch the cone. There the radius
goes with the root of the distance to the touching ray: its sensitivity grows without bound, noise bends the result, and
half of the peaks have no meeting at all. So near the fold the line is smoothed before it is triangulated: resolution is
given for noise where noise is all that single peaks show.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.lasers import MeetingFlag
from calibore.profiling._smoothing import smoothed_line
from calibore.rigs import Candidates, Rig, Triangulation, follow_stripe, margin, meetings_of, triangulate
from calibore.status import Status
from calibore.stripe import Stripe

Array = NDArray[np.float64]
NEAR_FOLD = 25.0
"""Margin below which the smoothed line counts."""
NOISE = 4.0
"""A peak more standard uncertainties off the smoothed line is no noise but the wall, and stands for itself."""
TOGETHER = 3.0
"""Ratio of the distances up to which two meetings are about to become one."""
MEASURABLE = 1.0
"""Least margin of a point worth a number (docs/decisions/0005)."""


class RingOnCone(NamedTuple):
    """Wall points of the rays of a closed stripe, and the standard uncertainty (n,) [px] of what was triangulated."""

    points: Triangulation
    u_position: Array


def triangulate_ring(stripe: Stripe, rig: Rig, *, laser: int, prior_radius: float) -> RingOnCone:
    """Wall points of a closed stripe on a surface that rays can meet twice; GRAZING where its margin is too small."""
    line = smoothed_line(stripe)
    candidates = _without_touching(meetings_of(rig, line.u, line.v, laser=laser))
    branch = follow_stripe(candidates, prior_radius)
    noise = line.noise * line.smaller
    m = margin(rig, line.u, line.v, branch=branch, u_pixel=noise, direction=stripe.direction, laser=laser)
    smooth = (m < NEAR_FOLD) & (np.abs(line.off) <= NOISE * line.noise)
    u, v = np.where(smooth, line.u, stripe.u), np.where(smooth, line.v, stripe.v)
    points = triangulate(rig, u, v, laser=laser, branch=branch)
    away = np.isfinite(candidates.radius).any(axis=0) & (m > MEASURABLE)
    grazing = stripe.found & ~away & np.isin(points.status, (Status.OK, Status.GRAZING))
    return RingOnCone(_without(points, grazing), np.where(smooth, noise, line.noise))


def _without_touching(candidates: Candidates) -> Candidates:
    """No radius on rays that touch the surface, grazing it at one of two meetings close together: the other one alone
    would tell the wrong branch. (A ray also grazes at a meeting far away, when it runs along the cone: no harm.)
    """
    grazed = ((candidates.flags & MeetingFlag.GRAZING) != 0).any(axis=0)
    distance = np.where(candidates.flags != MeetingFlag.NONE, np.abs(candidates.distance), np.nan)
    together = np.fmax.reduce(distance) <= TOGETHER * np.fmin.reduce(distance)
    return replace(candidates, radius=np.where(grazed & together, np.nan, candidates.radius))


def _without(points: Triangulation, grazing: NDArray[np.bool_]) -> Triangulation:
    """`points` with the rows `grazing` NaN and GRAZING."""

    def kept(values: Array) -> Array:
        return np.where(grazing.reshape(-1, *(1,) * (values.ndim - 1)), np.nan, values)

    return replace(
        points,
        points=kept(points.points),
        status=np.where(grazing, Status.GRAZING, points.status).astype(np.uint8),
        d_pixel=kept(points.d_pixel),
        d_parameters=kept(points.d_parameters),
    )

"""Where camera rays graze a cone of light, and what is left to measure there.

Round a ring the meeting changes from the near to the far one where the camera's rays touch the cone. There the radius
goes with the root of the distance to the touching ray: its sensitivity grows without bound, noise bends the result, and
half of the peaks have no meeting at all. So near the fold the line is smoothed before it is triangulated: resolution is
given for noise where noise is all that single peaks show.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._smoothing import smoothed_line
from calibore.rigs import Rig, Triangulation, follow_stripe, margin, meetings_of, triangulate
from calibore.status import Status
from calibore.stripe import Stripe

Array = NDArray[np.float64]
NEAR_FOLD = 25.0
"""Margin below which the smoothed line counts."""
NOISE = 4.0
"""A peak more standard uncertainties off the smoothed line is no noise but the wall, and stands for itself."""
MEASURABLE = 1.0
"""Least margin of a point worth a number (docs/decisions/0005)."""

SWAPPED = 0.15
"""Chance of the wrong branch where a ray touches the cone: what the scatter of 120 simulated rigs shows there."""


class RingOnCone(NamedTuple):
    """Wall points of the rays of a closed stripe, the standard uncertainty (n,) [px] of what was triangulated, and by
    how much (n,) the uncertainty of the radius is larger than to first order.
    """

    points: Triangulation
    u_position: Array
    enlargement: Array


class LineOnCone(NamedTuple):
    """What is triangulated of a closed stripe: `u`, `v` (n,) [px] on `branch` (n,), of standard uncertainty
    `u_position` (n,) [px] but for the `enlargement` (n,); a ray that meets the cone at all grazes it at `grazing` (n,).
    """

    u: Array
    v: Array
    branch: NDArray[np.intp]
    u_position: Array
    enlargement: Array
    grazing: NDArray[np.bool_]


def line_on_cone(stripe: Stripe, rig: Rig, *, laser: int, prior_radius: float) -> LineOnCone:
    """Which meeting with the cone each ray of a closed stripe is, and how well known its place in the picture."""
    line = smoothed_line(stripe)
    branch = follow_stripe(meetings_of(rig, line.u, line.v, laser=laser), prior_radius)
    noise = line.noise * line.smaller if rig.stripe is None else np.full(stripe.u.size, rig.stripe)
    m = margin(rig, line.u, line.v, branch=branch, u_pixel=noise, direction=stripe.direction, laser=laser)
    smooth = (m < NEAR_FOLD) & (np.abs(line.off) <= NOISE * line.noise)
    u, v = np.where(smooth, line.u, stripe.u), np.where(smooth, line.v, stripe.v)
    u_position = np.where(smooth, line.noise * line.smaller, line.noise)
    return LineOnCone(u, v, branch, u_position, enlargement(m), stripe.found & ~(m > MEASURABLE))


def triangulate_ring(stripe: Stripe, rig: Rig, *, laser: int, prior_radius: float) -> RingOnCone:
    """Wall points of a closed stripe on a surface that rays can meet twice; GRAZING where its margin is too small."""
    line = line_on_cone(stripe, rig, laser=laser, prior_radius=prior_radius)
    points = triangulate(rig, line.u, line.v, laser=laser, branch=line.branch)
    grazing = line.grazing & np.isin(points.status, (Status.OK, Status.GRAZING))
    return RingOnCone(_without(points, grazing), line.u_position, line.enlargement)


def enlargement(m: Array) -> Array:
    """True over first-order standard uncertainty (n,) of a meeting of margin `m` (n,); 1 where it has none.

    The radius goes with x = root of the distance to touching, of which m +- 1 was observed: x is distributed as
    exp(-(x^2 - m)^2 / 2) round the ring, where all x are as likely (JCGM 101, by quadrature). Continuity knows its
    sign, the branch, but for a chance that falls off as the distribution does where the branches meet.
    """
    return np.where(np.isfinite(m), np.interp(m, *enlargements(), right=1.0), 1.0)


@lru_cache(maxsize=1)
def enlargements() -> tuple[Array, Array]:
    """Margins and the enlargement at each."""
    m, x = np.linspace(MEASURABLE, 2 * NEAR_FOLD, 197), np.linspace(0, 10, 2001)
    root = np.sqrt(m)[:, None]
    density = np.exp(-((x**2 - root**2) ** 2) / 2)
    density /= density.sum(axis=1, keepdims=True)
    right, wrong = (np.sum(density * (sign * x - root) ** 2, axis=1) for sign in (1, -1))
    swapped = SWAPPED * np.exp(-(m**2) / 2)
    return m, 2 * np.sqrt(m * ((1 - swapped) * right + swapped * wrong))


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

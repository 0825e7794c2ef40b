"""One line in one image of one station: triangulate it, say how well each point is known."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.lasers import Cone
from calibore.profiling._fold import triangulate_ring
from calibore.rigs import Rig, Triangulation, triangulate
from calibore.status import Status, has_value
from calibore.stripe import Stripe

Array = NDArray[np.float64]
Statuses = NDArray[np.uint8]
NO_POINT = "no point of its line lies in the light of the laser in front of the camera; check the rig file"


@dataclass(frozen=True)
class TakePoints:
    """The rays of one image as wall points in the rig frame, n rays in order round the ring of one `laser`.

    `clock` [rad] is given for rays without a point too (interpolated). `along` (n,) [m/px]: radius per pixel along the
    ray the peak was measured on, at fixed clock; `turn` (n,) [rad/px]: clock per pixel along it. `u_position` (n,)
    [px]; `enlargement` of the radius's uncertainty where first order does not hold, one number or (n,).
    """

    points: Triangulation
    clock: Array
    along: Array
    turn: Array
    u_position: Array
    status: NDArray[np.uint8]
    stripe: Stripe
    laser: int = 0
    enlargement: Array | float = 1.0

    def displaced(self, by: Array) -> "TakePoints":
        """The same with its points moved `by` (n, 3) [m], a little, in the rig frame."""
        points = replace(self.points, points=self.points.points + by)
        return replace(self, points=points, clock=_every_clock(points.clock))


def place_on_wall(stripe: Stripe, rig: Rig, *, laser: int = 0, prior_radius: float | None = None) -> TakePoints:
    """The line as points of the wall; raises ImageError where none of it lies on the laser's surface.

    `prior_radius` [m], roughly the wall's, tells the meetings with a cone apart.
    """
    u_position, enlargement = stripe.u_position, 1.0
    if isinstance(rig.lasers[laser].surface, Cone) and prior_radius is not None:
        points, u_position, enlargement = triangulate_ring(stripe, rig, laser=laser, prior_radius=prior_radius)
    else:
        points = triangulate(rig, stripe.u, stripe.v, laser=laser, prior_radius=prior_radius)
    status = np.where(points.status == Status.OK, stripe.status, points.status)
    status = np.where(stripe.found, status, stripe.status).astype(np.uint8)
    along = np.einsum("nk,nk->n", points.radius_sensitivities.pixel, stripe.direction)
    turn = np.einsum("nk,nk->n", points.clock_sensitivities.pixel, stripe.direction)
    clock = _every_clock(points.clock)
    status = _told_outside(status, stripe, points, rig)
    return TakePoints(points, clock, along, turn, u_position, status, stripe, laser, enlargement)


def _told_outside(status: Statuses, stripe: Stripe, points: Triangulation, rig: Rig) -> Statuses:
    """`status` (n,) with EXTRAPOLATED where a value comes from outside the region where the rig was calibrated."""
    if rig.valid is None:
        return status
    zenith = np.arccos(np.clip(rig.camera.unproject(stripe.u, stripe.v).direction[:, 2], -1, 1))
    outside = has_value(status) & ~rig.valid.holds(zenith, points.radius)
    return np.where(outside, Status.EXTRAPOLATED, status).astype(np.uint8)


def _every_clock(clock: Array) -> Array:
    """`clock` (n,) with its gaps interpolated round the ring."""
    index, found = np.arange(clock.size), np.flatnonzero(np.isfinite(clock))
    if found.size == 0:
        raise ImageError(NO_POINT)
    turns = np.unwrap(clock[found])
    sense = np.sign(turns[-1] - turns[0]) or 1.0
    before, after = found[-1] - clock.size, found[0] + clock.size
    places = np.concatenate([[before], found, [after]])
    values = np.concatenate([[turns[-1] - sense * 2 * np.pi], turns, [turns[0] + sense * 2 * np.pi]])
    return np.mod(np.interp(index, places, values), 2 * np.pi)

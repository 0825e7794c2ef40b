"""One line of light in one picture: its rays on the wall, and its ring on the clock grid, by the compiled engine.

The specification is `place_on_wall`, `grid_ring` and `rays_of`; `native/src/rings/line.rs` and the files it uses are
the engine's form. Rigs that the engine does not know are computed by the specification.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore._native import ring_of_line
from calibore.errors import ImageError
from calibore.kernels import DEFAULT_KERNEL, is_native
from calibore.lasers import Cone
from calibore.profiling._fold import enlargements
from calibore.profiling._grid import POSITIONS, Ring, clock_grid, grid_ring
from calibore.profiling._take import NO_POINT, TakePoints, place_on_wall
from calibore.profiling._water import wet_rays, without_water
from calibore.rigs import FORWARD, Rig, engine_form
from calibore.stripe import Stripe
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]


class WallRays(NamedTuple):
    """The rays of one line in the rig frame: `points` (n, 3) [m], `radius` [m] with its standard uncertainty `u_radius`
    (n,), NaN where there is none; `clock` (n,) [rad] of all; the pixel `u`, `v` (n,) and `status` (n,).
    """

    points: Array
    radius: Array
    clock: Array
    u_radius: Array
    u: Array
    v: Array
    status: NDArray[np.uint8]


class LineOnWall(NamedTuple):
    """`rays` of a line, and the `ring` that they give."""

    rays: WallRays
    ring: Ring


def line_on_wall(
    stripe: Stripe,
    rig: Rig,
    *,
    laser: int = 0,
    prior_radius: float | None = None,
    displacement: Array | None = None,
    kernel: str = DEFAULT_KERNEL,
) -> LineOnWall:
    """The line `stripe` of `laser`; raises ImageError where none of it lies on the laser's surface.

    `prior_radius` [m], roughly the wall's, tells the meetings with a cone apart. `displacement` (n, 3) [m]: how far
    each point is moved in the rig frame; that is done in NumPy. What water mirrors is left out (`wet_rays`).
    """
    form = engine_form(rig, laser) if is_native(kernel) and rig.mount == FORWARD and displacement is None else None
    if form is not None and (prior_radius is not None or not isinstance(rig.lasers[laser].surface, Cone)):
        return _by_engine(stripe, rig, form, laser=laser, prior_radius=prior_radius)
    how: Any = {"laser": laser, "prior_radius": prior_radius, "displacement": displacement}
    found = _by_numpy(stripe, rig, **how)
    wet = wet_rays(found.rays.points, found.rays.clock, stripe, rig)
    return _by_numpy(without_water(stripe, wet), rig, **how) if wet.any() else found


def rays_of(take: TakePoints, covariance: Covariance) -> WallRays:
    """The rays of a take that was placed in NumPy."""
    sensitivities = take.points.radius_sensitivities.parameters
    common = propagate(sensitivities, covariance, names=take.points.parameter_names).u
    valued = np.where(np.isfinite(take.u_position), 0.0, np.nan)
    return WallRays(
        take.points.points,
        take.points.radius + valued,
        take.clock,
        np.hypot(take.along * take.u_position * take.enlargement, common),
        take.stripe.u,
        take.stripe.v,
        take.status,
    )


def _by_numpy(
    stripe: Stripe, rig: Rig, *, laser: int, prior_radius: float | None, displacement: Array | None
) -> LineOnWall:
    """All of a line that lies on the wall."""
    take = place_on_wall(stripe, rig, laser=laser, prior_radius=prior_radius)
    take = take if displacement is None else take.displaced(displacement)
    covariance = rig.covariance or Covariance.independent({})
    return LineOnWall(rays_of(take, covariance), grid_ring(take, covariance, stripe=rig.stripe))


def _by_engine(stripe: Stripe, rig: Rig, form: Any, *, laser: int, prior_radius: float | None) -> LineOnWall:
    line = (_plain(stripe.u), _plain(stripe.v), _plain(stripe.u_position), stripe.status, _plain(stripe.direction))
    cone = (prior_radius, *enlargements()) if isinstance(rig.lasers[laser].surface, Cone) else None
    limits = None if rig.valid is None else rig.valid.limits
    line = (*line, _plain(stripe.correlation), stripe.centre)
    found = ring_of_line(form, line, rig.stripe, limits, cone, POSITIONS)
    if found is None:
        raise ImageError(NO_POINT)
    (*rays, status), ((mean, axial, u), modes, correlation, of_ring), wet = found
    stripe = without_water(stripe, wet) if wet else stripe
    ring = Ring(clock_grid(), mean, axial, u, modes.reshape(-1, POSITIONS), of_ring, correlation)
    points, radius, clock, u_radius = rays
    return LineOnWall(WallRays(points, radius, clock, u_radius, stripe.u, stripe.v, status), ring)


def _plain(values: NDArray[Any]) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)

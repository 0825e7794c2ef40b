"""What a calibration's covariance means in metres on the wall: with all correlations, and, to compare, without."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.lasers import Beam
from calibore.rigs import Rig, SideFacing, Triangulation, lit_points, triangulate
from calibore.status import Status
from calibore.uncertainty import Covariance, propagate

Array = NDArray[Any]
CLOCKS = 72
ALONG = 160
"""Pixels along the longer side of a map."""
ON_THE_WALL = 1e-6
"""Of the radius, rounding: a point farther off belongs to another meeting."""


@dataclass(frozen=True, eq=False)
class WallUncertainty:
    """Standard uncertainty of the radius, shared by a whole scan: `u`, and `u_uncorrelated` if correlations are
    ignored, (r, c) [m] at `radius` (r,) [m] and `clock` (c,) [rad]; NaN where no laser shows the wall in the image.
    """

    radius: Array
    clock: Array
    u: Array
    u_uncorrelated: Array

    @property
    def mean(self) -> Array:
        """(r,) [m]: root of the mean variance over the clocks that are seen."""
        return root_mean_square(self.u)

    @property
    def mean_uncorrelated(self) -> Array:
        return root_mean_square(self.u_uncorrelated)


@dataclass(frozen=True, eq=False)
class WallMap:
    """At pixels `u` (w,), `v` (h,): the `radius` (h, w) that a line found there tells, and its `uncertainty` [m];
    `line`: pixels (2, n) of the wall of the nominal radius.
    """

    u: Array
    v: Array
    radius: Array
    uncertainty: Array
    line: Array


def wall_uncertainty(rig: Rig, *, radii: ArrayLike, clock: ArrayLike | None = None) -> WallUncertainty:
    """Of walls of `radii` [m] at `clock` [rad], all round where not given; of several lasers the one that knows best.

    A head that turns measures all clocks alike. Raises InputError where the rig states no covariance.
    """
    known = stated(rig)
    alone = Covariance(known.names, np.diag(np.diag(known.matrix)))
    radii, clock = np.atleast_1d(np.asarray(radii, dtype=float)), wall_clocks(rig, clock)
    slopes = wall_slopes(rig, radii, clock)
    return WallUncertainty(radii, clock, *(_u(slopes, rig, one) for one in (known, alone)))


def wall_slopes(rig: Rig, radii: Array, clock: Array) -> Array:
    """(r, c, p) derivatives of the radius by `rig.parameter_names`, of the laser that knows best; NaN unseen."""
    each = [_seen_slopes(rig, radii, clock, laser) for laser in range(len(rig.lasers))]
    u = np.stack([_u(slopes, rig, stated(rig)) for slopes in each])
    best = np.argmin(np.where(np.isfinite(u), u, np.inf), axis=0)
    return np.take_along_axis(np.stack(each), best[None, ..., None], axis=0)[0]


def wall_map(rig: Rig, *, nominal_radius: float, laser: int = 0) -> WallMap:
    """Over the image: what a line found at a pixel tells of the radius, near the wall of `nominal_radius` [m]."""
    camera = rig.camera
    longer = max(camera.width, camera.height)
    u, v = (
        np.linspace(0.0, size - 1.0, max(1, min(size, size * ALONG // longer)))
        for size in (camera.width, camera.height)
    )
    grid = np.meshgrid(u, v)
    found = triangulate(rig, grid[0].ravel(), grid[1].ravel(), laser=laser, prior_radius=nominal_radius)
    spread = propagate(found.radius_sensitivities.parameters, stated(rig), names=rig.parameter_names).u
    turns, reach = np.linspace(0, 2 * np.pi, 361), np.linspace(-1, 1, 361) * nominal_radius
    line = wall_pixels(rig, turns, np.full(361, nominal_radius), laser=laser, axial=reach)
    shape = grid[0].shape
    return WallMap(u, v, found.radius.reshape(shape), spread.reshape(shape), np.stack(_kept_in_image(rig, *line)))


def wall_clocks(rig: Rig, clock: ArrayLike | None = None) -> Array:
    """`clock`, or an even round of clocks; one for heads that turn, those of the beams for spot arrays."""
    if clock is not None:
        return np.atleast_1d(np.asarray(clock, dtype=float))
    if isinstance(rig.mount, SideFacing):
        return np.zeros(1)
    beams = [one.surface.clock for one in rig.lasers if isinstance(one.surface, Beam)]
    return np.array(beams) if beams else np.arange(CLOCKS) * (2 * np.pi / CLOCKS)


def wall_pixels(
    rig: Rig, clock: Array, radius: Array, *, laser: int = 0, axial: Array | float = 0.0
) -> tuple[Array, Array]:
    """Pixels u, v (n,) of what `laser` lights at `clock` and `radius` (n,); NaN where no light falls.

    The head of a side-facing rig is turned to the clock; `axial` [m] is the place along its sheet. A beam lights its
    own clock only.
    """
    return rig.project(lit_points(rig, clock, radius, laser=laser, axial=axial))


def on_the_wall(rig: Rig, radii: Array, clock: Array, *, laser: int = 0) -> tuple[Array, Array, Triangulation]:
    """Pixels u, v (r c,) of walls of `radii` (r,) at `clock` (c,), and what is triangulated there; NaN where `laser`
    does not show the wall in the image.
    """
    radius, clock = (a.ravel() for a in np.meshgrid(np.where(radii > 0, radii, np.nan), clock, indexing="ij"))
    u, v = _kept_in_image(rig, *wall_pixels(rig, clock, radius, laser=laser))
    found = triangulate(rig, u, v, laser=laser, prior_radius=radius)
    lost = (found.status != Status.OK) | ~(np.abs(found.radius - radius) <= ON_THE_WALL * radius)
    return np.where(lost, np.nan, u), np.where(lost, np.nan, v), found


def stated(rig: Rig) -> Covariance:
    """The covariance of a rig that has one."""
    if rig.covariance is None:
        raise InputError(
            "The rig states no uncertainty, so nothing can be said of its measurements; calibrate it, or add "
            "[uncertainty] to its file."
        )
    return rig.covariance


def root_mean_square(values: Array) -> Array:
    """Over the last axis, of what is finite; NaN where nothing is."""
    there = np.isfinite(values)
    count = there.sum(axis=-1)
    total = np.where(there, values, 0.0) ** 2
    return np.where(count > 0, np.sqrt(total.sum(axis=-1) / np.maximum(count, 1)), np.nan)


def _seen_slopes(rig: Rig, radii: Array, clock: Array, laser: int) -> Array:
    u, _, found = on_the_wall(rig, radii, clock, laser=laser)
    slopes = np.where(np.isnan(u)[:, None], np.nan, found.radius_sensitivities.parameters)
    if isinstance(rig.lasers[laser].surface, Beam):
        slopes = np.where(np.tile(np.arange(clock.size) == laser, radii.size)[:, None], slopes, np.nan)
    return slopes.reshape(radii.size, clock.size, -1)


def _u(slopes: Array, rig: Rig, known: Covariance) -> Array:
    flat = slopes.reshape(-1, slopes.shape[-1])
    return propagate(flat, known, names=rig.parameter_names).u.reshape(slopes.shape[:-1])


def _kept_in_image(rig: Rig, u: Array, v: Array) -> tuple[Array, Array]:
    camera = rig.camera
    inside = (u >= -0.5) & (u <= camera.width - 0.5) & (v >= -0.5) & (v <= camera.height - 0.5)
    return np.where(inside, u, np.nan), np.where(inside, v, np.nan)

"""Radius of the reference minus radius of moved points, and what it depends on."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import clock_of, xy_of
from calibore.registration._motion import Motion
from calibore.registration._slopes import clock_bends
from calibore.registration._surface import RESOLUTION, Surface
from calibore.scans import Profile

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cloud:
    """The points (p) of a moving profile, ring by ring: `points` (p, 3), `variance` (p,) [m^2] of their radii from
    noise, `missed` (p,) [m] beside edges, `modes` (q, p) [m], `ring` and `position` (p,) of the grid, `positions` per
    ring.
    """

    points: Array
    variance: Array
    missed: Array
    modes: Array
    ring: NDArray[np.intp]
    position: NDArray[np.intp]
    positions: int

    @classmethod
    def of(cls, profile: Profile) -> "Cloud":
        ring, position = np.nonzero(profile.measured)
        x, y = xy_of(profile.clock[position], profile.radius[ring, position])
        points = np.stack([x, y, profile.axial_position[ring, position]], axis=1)
        missed = np.zeros_like(profile.radius) if profile.sampled else RESOLUTION * clock_bends(profile)
        return cls(
            points,
            profile.u_independent[ring, position] ** 2,
            missed[ring, position],
            profile.common_mode[:, ring, position],
            ring,
            position,
            profile.clock.size,
        )

    def only(self, rows: NDArray[np.intp]) -> "Cloud":
        return Cloud(
            self.points[rows],
            self.variance[rows],
            self.missed[rows],
            self.modes[:, rows],
            self.ring[rows],
            self.position[rows],
            self.positions,
        )

    @cached_property
    def radius(self) -> Array:
        """(p,) [m] about the moving profile's own axis."""
        return np.hypot(self.points[:, 0], self.points[:, 1])


@dataclass(frozen=True, eq=False)
class Gaps:
    """`residual` (p,) [m], reference minus moved, NaN where there is no reference; its `variance` (p,) from noise, and
    `missed` (p,) [m] between points and beside edges, a standard deviation, alike for neighbours; `jacobian` (p, 8) of
    the residual by the motion, `modes` (q, p) by common errors of the moving profile, then of the reference; `doubt`
    (2, p, 8): one standard deviation of the jacobian from noise in either slope of the reference; `axial` [m], `clock`
    [rad], `radius` [m] (p,) of the moved points.
    """

    residual: Array
    variance: Array
    missed: Array
    jacobian: Array
    modes: Array
    doubt: Array
    axial: Array
    clock: Array
    radius: Array

    @property
    def total(self) -> Array:
        """Variance (p,) [m^2] of a residual, common errors apart."""
        return self.variance + self.missed**2


def gaps(cloud: Cloud, surface: Surface, motion: Motion, drift: Array | None = None) -> Gaps:
    """What is left between the moved points and the reference; `drift` (n, 3): roll [rad], shift in x, in y [m] by
    which each ring (n) is moved in addition.
    """
    moved, slopes = motion.apply_with_slopes(cloud.points)
    x, y, z = moved.T if drift is None else _drifted(moved, drift[cloud.ring])
    radius, clock = np.hypot(x, y), clock_of(x, y)
    place = surface.at(z, clock)
    outwards = np.stack([x, y], axis=1) / radius[:, None]
    by_radius = np.einsum("pi,pik->pk", outwards, slopes[:, :2])
    turning = np.stack([-outwards[:, 1], outwards[:, 0]], axis=1) / radius[:, None]
    by_clock, by_axial = np.einsum("pi,pik->pk", turning, slopes[:, :2]), slopes[:, 2]
    jacobian = place.by_axial[:, None] * by_axial + place.by_clock[:, None] * by_clock - by_radius
    doubt = (
        np.sqrt(np.maximum(place.noise_by_axial, 0.0))[:, None] * by_axial,
        np.sqrt(np.maximum(place.noise_by_clock, 0.0))[:, None] * by_clock,
    )
    return Gaps(
        place.radius - radius,
        cloud.variance * motion.scale**2 + place.variance,
        np.hypot(cloud.missed, place.missed),
        jacobian,
        np.concatenate([-motion.scale * cloud.modes, place.modes]),
        np.stack(doubt),
        z,
        clock,
        radius,
    )


def _drifted(points: Array, drift: Array) -> Array:
    c, s = np.cos(drift[:, 0]), np.sin(drift[:, 0])
    x, y, z = points.T
    return np.stack([c * x - s * y + drift[:, 1], s * x + c * y + drift[:, 2], z])


def residual_of(cloud: Cloud, surface: Surface, motion: Motion) -> tuple[Array, Array]:
    """Residual and variance only, for trying many motions."""
    x, y, z = motion.apply(cloud.points).T
    radius, variance, missed = surface.heights(z, clock_of(x, y))
    total = cloud.variance * motion.scale**2 + variance + cloud.missed**2 + missed**2
    return radius - np.hypot(x, y), total

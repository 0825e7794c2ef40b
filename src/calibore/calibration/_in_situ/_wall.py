"""The wall of a pipe as somebody else has measured it: a grid of radii, and the `Reference` that light falls on."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._references import Gap, Reference
from calibore.errors import InputError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

STEEPEST = 0.15
"""Slope of the wall beyond which it is no reference: a ball touches beside its tip, and a shift reads as radius."""
WIDEST = 2.5
"""Steps of the clock's grid: where its points are further apart, nothing is known between them."""
BEYOND = 0.1
"""Steps along the pipe beyond its end rings at which the wall is still taken for theirs."""
OVERLAP = 4
"""Clock positions that the spline has twice, beyond both ends of the turn."""
LONELY = 6.0
"""A radius so many robust standard deviations off its neighbours' median is a stuck probe or dirt."""
POSE = ("roll", "x", "y", "axial", "slope_x", "slope_y")
"""How the reference's frame lies in that of the scan: [rad], [m], [m], [m], and the slopes of its axis."""


class Height(NamedTuple):
    """`radius` (n,) [m] of the wall, its slopes by axial position [m/m] and by clock [m/rad]."""

    radius: Array
    by_axial: Array
    by_clock: Array


@dataclass(frozen=True, eq=False)
class WallGrid:
    """`radius` (m, n) [m] at `axial` (m,) [m], rising, and `clock` (n,) [rad], rising within one turn; NaN where it was
    not measured. `u` [m]: standard uncertainty that all radii share.

    `bends` (k, 2): k further causes by which all radii may be wrong together, one standard deviation of each being
    bends[:, 0] (R - pivot) + bends[:, 1] (R - pivot)^2 with `pivot` [m].
    """

    axial: Array
    clock: Array
    radius: Array
    u: float = 0.0
    bends: Array = field(default_factory=lambda: np.zeros((0, 2)))
    pivot: float = 0.0

    def __post_init__(self) -> None:
        if self.radius.shape != (self.axial.size, self.clock.size) or self.clock.size < 8:
            raise InputError(
                f"A reference profile is a grid of at least one ring with 8 clock positions, got {self.radius.shape}."
            )
        if not np.isfinite(self.radius).any():
            raise InputError("The reference profile holds no radius at all.")

    @cached_property
    def filled(self) -> Array:
        """The radii, gaps filled around the clock, so that a search can pass over them; they are never `usable`."""
        rows = [_around(self.clock, row) for row in self.radius]
        known = [i for i, row in enumerate(rows) if row is not None]
        return np.array([rows[min(known, key=lambda k, i=i: abs(k - i))] for i in range(len(rows))])

    @cached_property
    def sound(self) -> Mask:
        """(m, n): measured, no loner among its neighbours, not steep, nor beside such."""
        known, wall = np.isfinite(self.radius), self.filled
        off = np.abs(wall - np.median([wall, *_neighbours(wall)], axis=0))
        lonely = off > LONELY * 1.4826 * max(float(np.median(off[known])), 1e-6)
        steep = np.zeros_like(known)
        if self.axial.size > 1:
            steep |= np.abs(np.gradient(wall, self.axial, axis=0)) > STEEPEST
        turn = np.concatenate([[self.clock[-1] - 2 * np.pi], self.clock, [self.clock[0] + 2 * np.pi]])
        around = np.gradient(np.concatenate([wall[:, -1:], wall, wall[:, :1]], axis=1), turn, axis=1)[:, 1:-1]
        steep |= np.abs(around) > STEEPEST * wall
        bad = ~known | lonely | steep
        return ~(bad | np.any(_neighbours(bad), axis=0))

    @cached_property
    def _surface(self) -> Any:
        """Cubic splines through the grid: slopes without jumps, so that a search settles."""
        from scipy.interpolate import RectBivariateSpline

        turn, wall = 2 * np.pi, self.filled
        clock = np.concatenate([self.clock[-OVERLAP:] - turn, self.clock, self.clock[:OVERLAP] + turn])
        wall = np.concatenate([wall[:, -OVERLAP:], wall, wall[:, :OVERLAP]], axis=1)
        axial = self.axial
        if axial.size == 1:
            axial, wall = axial[0] + np.array([-1.0, 1.0]), np.repeat(wall, 2, axis=0)
        return RectBivariateSpline(axial, clock, wall, kx=min(3, axial.size - 1), ky=3)

    def height(self, axial: Array, clock: Array) -> Height:
        """Between the grid's points smooth; beyond its ends as at them."""
        inside, clock = self._inside(axial, clock)
        surface = self._surface
        rising = np.where(inside == axial, surface.ev(inside, clock, dx=1), 0.0) if self.axial.size > 1 else 0.0 * axial
        return Height(surface.ev(inside, clock), rising, surface.ev(inside, clock, dy=1))

    def radius_at(self, axial: Array, clock: Array) -> Array:
        """The same without slopes."""
        return self._surface.ev(*self._inside(axial, clock))

    def _inside(self, axial: Array, clock: Array) -> tuple[Array, Array]:
        turned = self.clock[0] + (clock - self.clock[0]) % (2 * np.pi)
        return np.clip(axial, self.axial[0], self.axial[-1]), turned

    def usable(self, axial: Array, clock: Array) -> Mask:
        """Whether the wall (n,) around there is `sound`, and within the rings measured."""
        i, (j, turn) = self._row(axial), self._column(clock)
        last, following = np.minimum(i + 1, self.axial.size - 1), (j + 1) % self.clock.size
        sound = self.sound[i, j] & self.sound[i, following] & self.sound[last, j] & self.sound[last, following]
        close = turn <= WIDEST * float(np.median(np.diff(self.clock)))
        return sound & close & ((self.axial.size == 1) | self._within(axial))

    def _within(self, axial: Array) -> Mask:
        slack = BEYOND * np.ptp(self.axial) / max(self.axial.size - 1, 1)
        return (axial >= self.axial[0] - slack) & (axial <= self.axial[-1] + slack)

    def _row(self, axial: Array) -> NDArray[np.intp]:
        """The ring (n,) before each place."""
        return np.clip(np.searchsorted(self.axial, axial, side="right") - 1, 0, max(self.axial.size - 2, 0))

    def _column(self, clock: Array) -> tuple[NDArray[np.intp], Array]:
        """The clock position (n,) before each place, and how far (n,) [rad] the next is from it."""
        starts = self.clock - self.clock[0]
        places = (clock - self.clock[0]) % (2 * np.pi)
        j = np.clip(np.searchsorted(starts, places, side="right") - 1, 0, starts.size - 1)
        return j, np.diff(np.append(starts, 2 * np.pi))[j]


@dataclass(frozen=True, eq=False)
class WallReference(Reference):
    """`wall` seen from a rig that stands at `axial` [m] and is turned by `roll` [rad] in the frame of its scan; `pose`
    (6,): how the reference's frame lies in that, as far as it is known beforehand; `u_pose` (6,): how well.
    """

    wall: WallGrid
    axial: float
    roll: float
    pose: Array
    u_pose: Array
    u: float | None = None

    @property
    def nuisance_names(self) -> tuple[str, ...]:
        return (*POSE, *(f"bend_{cause}" for cause in range(len(self.wall.bends))))

    @property
    def nuisance_u(self) -> Array:
        return np.concatenate([self.u_pose, np.ones(len(self.wall.bends))])

    def place(self, points: Array, pose: Array) -> tuple[Array, Array, Array]:
        """x, y, z (n,) [m] in the reference's frame of `points` (n, 3) of the rig's."""
        roll, x, y, axial, slope_x, slope_y = pose
        c, s = np.cos(self.roll + roll), np.sin(self.roll + roll)
        z = points[:, 2] + self.axial + axial
        along = z - self.wall.axial.mean()
        return (
            c * points[:, 0] - s * points[:, 1] + x + slope_x * along,
            s * points[:, 0] + c * points[:, 1] + y + slope_y * along,
            z,
        )

    def gap(self, points: Array, nuisance: Array) -> Gap:
        """R - R_ref(z, clock) - what the reference's bends add at R."""
        pose, bent = self.pose + nuisance[: len(POSE)], nuisance[len(POSE) :] @ self.wall.bends
        x, y, z = self.place(points, pose)
        wall, along = self.wall.height(z, np.arctan2(x, -y)), z - self.wall.axial.mean()
        radius = np.hypot(x, y)
        off = radius - self.wall.pivot
        outwards = 1 - bent[0] - 2 * bent[1] * off
        by_x = outwards * x / radius + wall.by_clock * y / radius**2
        by_y = outwards * y / radius - wall.by_clock * x / radius**2
        by_z = by_x * pose[4] + by_y * pose[5] - wall.by_axial
        c, s = np.cos(self.roll + pose[0]), np.sin(self.roll + pose[0])
        by_point = np.stack([c * by_x + s * by_y, c * by_y - s * by_x, by_z], axis=1)
        by_roll = by_x * -(s * points[:, 0] + c * points[:, 1]) + by_y * (c * points[:, 0] - s * points[:, 1])
        by_pose = np.stack([by_roll, by_x, by_y, by_z, by_x * along, by_y * along], axis=1)
        by_bends = -np.stack([off, off**2], axis=1) @ self.wall.bends.T
        value = radius - wall.radius - bent[0] * off - bent[1] * off**2
        return Gap(value, by_point, np.concatenate([by_pose, by_bends], axis=1))


def _around(clock: Array, row: Array) -> Array | None:
    """The row with its gaps filled linearly around the clock; None where it is empty."""
    known = np.isfinite(row)
    return np.interp(clock, clock[known], row[known], period=2 * np.pi) if known.any() else None


def _neighbours(grid: NDArray[Any]) -> list[NDArray[Any]]:
    """The grid (m, n) seen from its eight neighbours: around the clock without end, along the pipe with ends."""
    rows = np.pad(grid, ((1, 1), (0, 0)), mode="edge")
    places = ((down, turn) for down in (0, 1, 2) for turn in (-1, 0, 1) if (down, turn) != (1, 0))
    return [np.roll(rows[down : down + len(grid)], turn, axis=1) for down, turn in places]

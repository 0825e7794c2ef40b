"""What a ball that is pushed out touches first: of all wall points beside its line, the one that stops it earliest.

A wall point that lies d beside the pin's line stops a ball of radius rho when its centre is sqrt(rho^2 - d^2) short of
it; the reading is the end of the ball. Points are looked for in a disc round where the line meets the wall, first
coarsely (closer together where an edge is near), then ever more finely round the best; their places are exact,
whichever way the probe stands in the pipe.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose, clock_of
from calibore.simulation._fan import distance_to_wall
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

COARSE = 0.26  # tip radii between points at first
CLOSE = 0.05  # where the wall is uneven: an edge that the side of the ball touches stops it within less
UNEVEN = 1.5  # tip radii that the wall rises or falls by within the disc
ROUNDS = 4  # each twice finer: 0.016 tip radii in the end, 3e-5 of them in depth
SQUARE = np.mgrid[-2:3, -2:3].reshape(2, 1, -1)
AT_ONCE = 64  # pins looked at closely, for the sake of memory
SIDEWAYS = 1.25  # of the disc's radius: what stands inwards is narrower, a pin may be askew


@dataclass(frozen=True)
class Shank:
    """The pin behind the ball: a rod of `radius` [m] whose flat front is `setback` [m] behind the end of the ball."""

    radius: float
    setback: float

    def __post_init__(self) -> None:
        if not (self.radius > 0 and self.setback > 0):
            raise InputError(
                f"A shank needs a positive radius and setback, got {1e3 * self.radius:g} mm and "
                f"{1e3 * self.setback:g} mm."
            )


@dataclass(frozen=True, eq=False)
class Touch:
    """For n stops: `reading` [m] to the end of the ball from the axis it turns about, `wall` [m] where the pin points,
    and whether the `shank` touched, not the ball.
    """

    reading: Array
    wall: Array
    shank: NDArray[np.bool_]


def touched(
    wall: PipeWall, pipe_from_probe: Pose, clock: Array, *, tip_radius: float, shank: Shank | None = None
) -> Touch:
    """First contacts of a pin that points to each `clock` (n,) [rad] of the probe's frame, square to its z axis."""
    pointing = np.stack([np.sin(clock), -np.cos(clock), np.zeros_like(clock)], axis=-1)
    source, rays = pipe_from_probe.translation, pointing @ pipe_from_probe.rotation.T
    ahead = distance_to_wall(wall, source, rays)
    middle = source + ahead[:, None] * rays
    pins = _Pins(wall, source, rays, clock_of(middle[:, 0], middle[:, 1]), middle[:, 2], tip_radius, shank)
    return pins.first(ahead)


@dataclass(frozen=True, eq=False)
class _Pins:
    """n pins from `source` along `rays` (n, 3), which meet the wall at `clock`, `axial` (n,) of the pipe."""

    wall: PipeWall
    source: Array
    rays: Array
    clock: Array
    axial: Array
    tip_radius: float
    shank: Shank | None

    def first(self, ahead: Array) -> Touch:
        """The ball's or the shank's first contact."""
        reach = SIDEWAYS * max(self.tip_radius, self.shank.radius if self.shank else 0.0)
        nowhere = np.zeros((2, ahead.size))
        spacing = np.full(ahead.size, COARSE * self.tip_radius)
        place, reading, shank, relief = self._best(nowhere, _disc(reach, COARSE * self.tip_radius))
        uneven = np.flatnonzero(relief > UNEVEN * self.tip_radius)
        for part in np.array_split(uneven, 1 + uneven.size // AT_ONCE):
            close = self._some(part)._best(nowhere[:, part], _disc(reach, CLOSE * self.tip_radius))
            place[:, part], reading[part], shank[part], _ = close
        spacing[uneven] = CLOSE * self.tip_radius
        for _ in range(ROUNDS):
            place, reading, shank, _ = self._best(place, SQUARE * (spacing / 2)[:, None])
            spacing = spacing / 2
        return Touch(reading, ahead, shank)

    def _some(self, index: NDArray[np.intp]) -> "_Pins":
        return replace(self, rays=self.rays[index], clock=self.clock[index], axial=self.axial[index])

    def _best(self, place: Array, aside: Array) -> tuple[Array, Array, NDArray[np.bool_], Array]:
        """Of the points `aside` (2, [n,] k) [m] from each `place` (2, n) the one that stops its pin first: where it is,
        the reading (n,), whether the shank is stopped; and the range of the wall's radius among them all.
        """
        offsets = place[..., None] + (aside if aside.ndim == 3 else aside[:, None])
        stops, shanks, relief = self._stops(*offsets)
        each, best = np.arange(len(stops)), np.argmin(stops, axis=1)
        return offsets[:, each, best], stops[each, best], shanks[each, best], relief

    def _stops(self, round_: Array, along: Array) -> tuple[Array, NDArray[np.bool_], Array]:
        """Reading (n, k) [m] at which the wall point `round_` and `along` [m] (n, k) from the middle would stop the
        pin, infinite where it passes by; whether its shank; the range (n,) [m] of the radius.
        """
        clock = self.clock[:, None] + round_ / self.wall.nominal_radius
        axial = self.axial[:, None] + along
        radius = self.wall.radius(axial, clock)
        x, y, z = (
            radius * np.sin(clock) - self.source[0],
            -radius * np.cos(clock) - self.source[1],
            axial - self.source[2],
        )
        relief = np.ptp(radius, axis=1)
        towards = [self.rays[:, None, n] for n in range(3)]
        ahead = x * towards[0] + y * towards[1] + z * towards[2]
        square = x * x + y * y + z * z - ahead * ahead
        with np.errstate(invalid="ignore"):
            ball = ahead + self.tip_radius - np.sqrt(self.tip_radius**2 - square)
        ball = np.where(np.isnan(ball), np.inf, ball)
        if self.shank is None:
            return ball, np.zeros(ball.shape, dtype=bool), relief
        rod = np.where(square < self.shank.radius**2, ahead + self.shank.setback, np.inf)
        return np.minimum(ball, rod), rod < ball, relief


def _disc(radius: float, spacing: float) -> Array:
    """Points (2, k) [m] within `radius` of the middle, which is one of them."""
    count = int(np.ceil(radius / spacing))
    x, y = np.mgrid[-count : count + 1, -count : count + 1].reshape(2, -1) * spacing
    return np.stack([x, y])[:, np.hypot(x, y) <= radius]

"""What makes a wall differ from a perfect cylinder: small parts that reshape the radius, in the order they are listed.

Axial positions and lengths in m, clocks in rad (formats.md, section 1). Every edge is smooth over a stated width, so
that the wall has a normal everywhere.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

SPLINE_MEAN_SQUARE = 151 / 315  # of a cubic B-spline: its variance in each of two directions
CREST = 8.0  # standard deviations that no roughness exceeds: knots are clipped there, at 3.8 of their own


def turned(clock: NDArray[Any], origin: ArrayLike) -> NDArray[Any]:
    """`clock` - `origin` [rad], wrapped to [-pi, pi)."""
    return np.mod(clock - np.asarray(origin) + np.pi, 2 * np.pi) - np.pi


def smooth_step(x: Array) -> Array:
    """0 below 0, 1 above 1, and a cubic with level ends between."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3 - 2 * x)


def require_positive(**lengths: float) -> None:
    for name, value in lengths.items():
        if not 0 < value < np.inf:
            raise InputError(f"{name.replace('_', ' ')} must be positive and finite, got {value:g}.")


class WallPart(ABC):
    """One feature of a wall."""

    @abstractmethod
    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        """The radius (n,) [m] with this feature, from the `radius` without it."""

    @abstractmethod
    def reach(self, nominal_radius: float) -> float:
        """How far [m] this feature may stand inwards."""

    def recess(self, nominal_radius: float) -> float:
        """How far [m] it may stand outwards: as far as inwards, where a part does not know better."""
        return self.reach(nominal_radius)


@dataclass(frozen=True)
class Ovality(WallPart):
    """r = R0 (1 + percent / 100 cos 2 (clock - axis)): wide at `axis` and opposite. `percent` goes linearly from its
    first to its second value between the two `axial` positions, and stays there beyond them.
    """

    percent: tuple[float, float]
    axial: tuple[float, float] = (0.0, 1.0)
    axis: float = np.pi / 2

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        percent = np.interp(axial, self.axial, self.percent)
        return radius + nominal_radius / 100 * percent * np.cos(2 * (clock - self.axis))

    def reach(self, nominal_radius: float) -> float:
        return nominal_radius / 100 * max(map(abs, self.percent))


@dataclass(frozen=True)
class Harmonic(WallPart):
    """`amplitude` [m] times cos(order (clock - axis))."""

    order: int
    amplitude: float
    axis: float = 0.0

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        return radius + self.amplitude * np.cos(self.order * (clock - self.axis))

    def reach(self, nominal_radius: float) -> float:
        return abs(self.amplitude)


@dataclass(frozen=True)
class Dent(WallPart):
    """A Gaussian dent of `depth` [m] inwards (negative: a bulge), with standard deviations `clock_width`, `length`."""

    depth: float
    clock: float
    axial: float
    clock_width: float
    length: float

    def __post_init__(self) -> None:
        require_positive(width_of_a_dent=self.clock_width, length_of_a_dent=self.length)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        across, along = turned(clock, self.clock) / self.clock_width, (axial - self.axial) / self.length
        return radius - self.depth * np.exp(-0.5 * (across * across + along * along))

    def reach(self, nominal_radius: float) -> float:
        return max(self.depth, 0.0)

    def recess(self, nominal_radius: float) -> float:
        return max(-self.depth, 0.0)


@dataclass(frozen=True)
class Rail(WallPart):
    """A bar along the pipe from the first to the second `axial` position: its flat top is `height` [m] above the
    nominal wall and `width` [m] wide, at `clock`.
    """

    height: float
    width: float
    clock: float = np.pi
    axial: tuple[float, float] = (-np.inf, np.inf)
    edge: float = 0.001

    def __post_init__(self) -> None:
        require_positive(height_of_a_rail=self.height, width_of_a_rail=self.width, edge_of_a_rail=self.edge)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        angle = turned(clock, self.clock)
        ahead = np.abs(angle) < 1.0
        top = (nominal_radius - self.height) / np.cos(np.where(ahead, angle, 0.0))
        aside = self.width / 2 - top * np.abs(np.sin(angle))
        inside = np.minimum(aside, np.minimum(axial - self.axial[0], self.axial[1] - axial))
        return radius - np.where(ahead, np.maximum(radius - top, 0.0) * smooth_step(inside / self.edge), 0.0)

    def reach(self, nominal_radius: float) -> float:
        return self.height

    def recess(self, nominal_radius: float) -> float:
        return 0.0


@dataclass(frozen=True)
class LateralOpening(WallPart):
    """A round recess of `radius` [m] where a lateral leaves the pipe, `depth` [m] deep, with a bevelled `edge`."""

    radius: float
    depth: float
    clock: float
    axial: float
    edge: float = 0.01

    def __post_init__(self) -> None:
        require_positive(radius_of_an_opening=self.radius, depth_of_an_opening=self.depth, edge=self.edge)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        distance = np.hypot(axial - self.axial, nominal_radius * turned(clock, self.clock))
        return radius + self.depth * smooth_step((self.radius - distance) / self.edge)

    def reach(self, nominal_radius: float) -> float:
        return 0.0

    def recess(self, nominal_radius: float) -> float:
        return max(self.depth, 0.0)


@dataclass(frozen=True)
class OffsetJoint(WallPart):
    """Beyond `axial` the pipe's axis is displaced by `offset` [m] towards `clock`, over a length of `edge` [m]."""

    offset: float
    clock: float
    axial: float
    edge: float = 0.003

    def __post_init__(self) -> None:
        require_positive(edge_of_a_joint=self.edge)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        return radius + self.offset * np.cos(clock - self.clock) * smooth_step((axial - self.axial) / self.edge)

    def reach(self, nominal_radius: float) -> float:
        return abs(self.offset)


@dataclass(frozen=True, eq=False)
class Roughness(WallPart):
    """A random smooth texture of standard deviation `rms` [m]: cubic splines on a lattice of `grain` [m]."""

    rms: float
    grain: float = 0.003
    seed: int = 0
    cells_along: int = 256

    def __post_init__(self) -> None:
        require_positive(rms_of_roughness=self.rms, grain_of_roughness=self.grain)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        from scipy.ndimage import map_coordinates

        table = self._table(nominal_radius)
        place = np.stack([clock * (len(table) / (2 * np.pi)), axial / self.grain])
        height = map_coordinates(table, place.reshape(2, -1), order=3, mode="grid-wrap", prefilter=False)
        return radius + height.reshape(place.shape[1:])

    def reach(self, nominal_radius: float) -> float:
        return CREST * self.rms

    @cached_property
    def _tables(self) -> dict[int, Any]:
        return {}

    def _table(self, nominal_radius: float) -> Array:
        """Spline coefficients (cells round, cells along) [m]."""
        cells = max(int(2 * np.pi * nominal_radius / self.grain), 8)
        if cells not in self._tables:
            values = np.random.default_rng(self.seed).standard_normal((cells, self.cells_along))
            self._tables[cells] = np.clip(values / SPLINE_MEAN_SQUARE, -CREST, CREST) * self.rms
        return self._tables[cells]

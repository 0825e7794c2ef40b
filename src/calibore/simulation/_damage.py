"""More parts of a wall: what pipes of the test benches and of the street have beside the usual."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.scans import Profile
from calibore.simulation._parts import WallPart, require_positive, smooth_step, turned

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConicalProtrusion(WallPart):
    """A cone that stands `height` [m] inwards on a base of `base_radius` [m], cut off where its radius is `top_radius`
    [m], as on the dissertation's test pipe (Swanbom 2007, 6.3); lengths on the developed wall.
    """

    height: float
    base_radius: float
    top_radius: float
    clock: float
    axial: float
    edge: float = 0.001

    def __post_init__(self) -> None:
        require_positive(height_of_a_cone=self.height, base_radius_of_a_cone=self.base_radius, edge=self.edge)
        if not 0 <= self.top_radius < self.base_radius:
            raise InputError(
                f"The top of a cone has a radius from 0 to less than its base's {self.base_radius:g} m, got "
                f"{self.top_radius:g} m."
            )

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        distance = np.hypot(axial - self.axial, nominal_radius * turned(clock, self.clock))
        slope = self.height / (self.base_radius - self.top_radius)
        flank = np.minimum((self.base_radius - distance) * slope, self.height)
        return radius - np.maximum(flank, 0.0) * smooth_step((self.base_radius - distance) / self.edge)

    def reach(self, nominal_radius: float) -> float:
        return self.height

    def recess(self, nominal_radius: float) -> float:
        return 0.0


@dataclass(frozen=True)
class Crack(WallPart):
    """A gap `width` [m] wide and `depth` [m] deep from one `axial` position at one `clock` to another, straight on the
    developed wall, the short way round.
    """

    width: float
    depth: float
    axial: tuple[float, float]
    clock: tuple[float, float]
    edge: float = 0.0005

    def __post_init__(self) -> None:
        require_positive(width_of_a_crack=self.width, depth_of_a_crack=self.depth, edge=self.edge)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        turn = nominal_radius * turned(np.array(self.clock[1]), self.clock[0])
        ends = np.array([self.axial[1] - self.axial[0], turn])
        place = np.stack([axial - self.axial[0], nominal_radius * turned(clock, self.clock[0])])
        along = np.clip(np.tensordot(ends, place, axes=1) / max(float(ends @ ends), 1e-12), 0.0, 1.0)
        aside = np.hypot(*(place - along * ends.reshape(-1, *[1] * axial.ndim)))
        return radius + self.depth * smooth_step((self.width / 2 - aside) / self.edge + 0.5)

    def reach(self, nominal_radius: float) -> float:
        return 0.0

    def recess(self, nominal_radius: float) -> float:
        return self.depth


@dataclass(frozen=True)
class Corrugation(WallPart):
    """Waves round the pipe, `amplitude` [m] times cos(2 pi (axial - crest) / pitch), outwards at the `crest` [m]."""

    amplitude: float
    pitch: float
    crest: float = 0.0

    def __post_init__(self) -> None:
        require_positive(pitch_of_a_corrugation=self.pitch)

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        return radius + self.amplitude * np.cos(2 * np.pi * (axial - self.crest) / self.pitch)

    def reach(self, nominal_radius: float) -> float:
        return abs(self.amplitude)


@dataclass(frozen=True, eq=False)
class MeasuredWall(WallPart):
    """The wall as a `profile` measured it before, in place of all that came before this part: smooth between its
    points, gaps filled from their surroundings, beyond its ends as at them.
    """

    profile: Profile

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        first, last = self.profile.axial[0], self.profile.axial[-1]
        place = np.clip(axial, first, last), np.mod(clock - self.profile.clock[0], 2 * np.pi) + self.profile.clock[0]
        return self._surface.ev(*place)

    def reach(self, nominal_radius: float) -> float:
        return max(nominal_radius - float(self._filled.min()), 0.0)

    def recess(self, nominal_radius: float) -> float:
        return max(float(self._filled.max()) - nominal_radius, 0.0)

    @cached_property
    def _filled(self) -> Array:
        """(n, m): missing radii interpolated round the clock, rings without any taken from the nearest that has."""
        clock, rows = self.profile.clock, []
        for row in self.profile.radius:
            known = np.isfinite(row)
            rows.append(np.interp(clock, clock[known], row[known], period=2 * np.pi) if known.any() else None)
        known = [i for i, row in enumerate(rows) if row is not None]
        return np.stack([rows[min(known, key=lambda k, i=i: abs(k - i))] for i in range(len(rows))])

    @cached_property
    def _surface(self) -> Any:
        from scipy.interpolate import RectBivariateSpline

        clock, radius, axial = self.profile.clock, self._filled, self.profile.axial
        around = np.concatenate([clock[-3:] - 2 * np.pi, clock, clock[:4] + 2 * np.pi])
        radius = np.concatenate([radius[:, -3:], radius, radius[:, :4]], axis=1)
        if axial.size == 1:
            axial, radius = axial[0] + np.array([-1.0, 1.0]), np.repeat(radius, 2, axis=0)
        return RectBivariateSpline(axial, around, radius, kx=min(3, axial.size - 1), ky=3)

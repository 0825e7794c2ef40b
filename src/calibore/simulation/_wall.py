"""The wall of a pipe: a nominal cylinder and the parts that reshape it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import clock_of
from calibore.simulation._finish import Finish
from calibore.simulation._parts import WallPart
from calibore.simulation._water import Water

Array = NDArray[np.float64]

DIFFERENCE = 1e-6
"""Step of central differences [m]: the wall is smooth at 1 mm, so their error is far below any noise."""


@dataclass(frozen=True)
class PipeWall:
    """`nominal_radius` [m]; `parts` reshape it one after the other. The pipe's axis is z, the wall endless. No
    `finish`: the nominal one, matt; `water` may stand in it.
    """

    nominal_radius: float
    parts: tuple[WallPart, ...] = ()
    finish: Finish | None = None
    water: Water | None = None

    def __post_init__(self) -> None:
        if not 0 < self.nominal_radius < np.inf:
            raise InputError(f"The nominal radius must be positive, got {self.nominal_radius} m; give it in metres.")
        if self.clearance <= 0:
            raise InputError(
                f"The wall's parts stand {self.nominal_radius - self.clearance:g} m inwards, beyond the axis of a pipe "
                f"of nominal radius {self.nominal_radius:g} m; make them smaller."
            )

    @property
    def clearance(self) -> float:
        """Radius [m] about the axis that no part of the wall reaches into."""
        return self.nominal_radius - sum(part.reach(self.nominal_radius) for part in self.parts)

    @property
    def extent(self) -> float:
        """Radius [m] about the axis that no part of the wall reaches beyond."""
        return self.nominal_radius + sum(part.recess(self.nominal_radius) for part in self.parts)

    def radius(self, axial: ArrayLike, clock: ArrayLike) -> Array:
        """Distance [m] of the wall from the pipe's axis at `axial` [m] and `clock` [rad], which broadcast."""
        axial, clock = np.broadcast_arrays(np.asarray(axial, dtype=float), np.asarray(clock, dtype=float))
        radius = np.full(axial.shape, self.nominal_radius)
        for part in self.parts:
            radius = part.reshaped(radius, axial, clock, self.nominal_radius)
        return radius

    def slopes(self, axial: Array, clock: Array) -> tuple[Array, Array]:
        """Derivatives of the radius by the axial position [-] and by the clock [m/rad]."""
        turn = DIFFERENCE / self.nominal_radius
        by_axial = self.radius(axial + DIFFERENCE, clock) - self.radius(axial - DIFFERENCE, clock)
        by_clock = self.radius(axial, clock + turn) - self.radius(axial, clock - turn)
        return by_axial / (2 * DIFFERENCE), by_clock / (2 * turn)

    def depth(self, points: Array) -> Array:
        """How far (...,) [m] the points (..., 3) of the pipe frame lie inside the wall; negative in the open."""
        x, y, z = np.moveaxis(points, -1, 0)
        return np.hypot(x, y) - self.radius(z, clock_of(x, y))

    def dry(self, points: Array) -> NDArray[np.bool_]:
        """Which `points` (n, 3) of the pipe frame lie above the water."""
        if self.water is None:
            return np.ones(len(points), dtype=bool)
        return ~self.water.covers(points, self.nominal_radius)

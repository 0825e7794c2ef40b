"""Dirt: stains on the wall that return another share of the light, and deposits that stand up from it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.simulation._parts import WallPart, require_positive, smooth_step, turned

Array = NDArray[np.float64]

BRIGHTEST = 4.0  # reflectance, in units of the nominal wall's: a grey pipe with white lime on it
CELLS_ALONG = 256  # cells of specks before the pattern repeats along the pipe


def require_reflectance(value: float, *, of: str) -> None:
    if not 0 <= value <= BRIGHTEST:
        raise InputError(
            f"The reflectance of {of} must be between 0 (black) and {BRIGHTEST:g}, got {value:g}; 1 is nominal."
        )


class Stain(ABC):
    """Where it covers the wall, it returns `reflectance` of the light, and matt."""

    reflectance: float

    @abstractmethod
    def cover(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        """How much (n,) of the wall it covers at `axial` [m] and `clock` [rad] (n,) of the pipe: 0 to 1."""


@dataclass(frozen=True)
class Patch(Stain):
    """A round stain of `radius` [m] about `clock` [rad] and `axial` [m], fading over its outermost `edge` [m]; it may
    stand `height` [m] up from the wall (`Deposit`).
    """

    clock: float
    axial: float
    radius: float
    reflectance: float = 0.05
    edge: float = 0.005
    height: float = 0.0

    def __post_init__(self) -> None:
        require_positive(radius_of_a_patch=self.radius, edge_of_a_patch=self.edge)
        require_reflectance(self.reflectance, of="a patch")
        if not 0 <= self.height < np.inf:
            raise InputError(f"A patch stands {self.height:g} m up from the wall; its height must not be negative.")

    def cover(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        distance = np.hypot(axial - self.axial, nominal_radius * turned(clock, self.clock))
        return smooth_step((self.radius - distance) / self.edge)


@dataclass(frozen=True)
class Band(Stain):
    """All round the pipe from the first to the second `axial` position [m], as a dark joint, fading over `edge` [m]."""

    axial: tuple[float, float]
    reflectance: float = 0.05
    edge: float = 0.001

    def __post_init__(self) -> None:
        require_positive(length_of_a_band=self.axial[1] - self.axial[0], edge_of_a_band=self.edge)
        require_reflectance(self.reflectance, of="a band")

    def cover(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        return smooth_step(np.minimum(axial - self.axial[0], self.axial[1] - axial) / self.edge)


@dataclass(frozen=True, eq=False)
class Specks(Stain):
    """Round specks of up to `radius` [m], one in every square of `spacing` [m], at random places (`seed`)."""

    spacing: float
    radius: float
    reflectance: float = 0.05
    seed: int = 0

    def __post_init__(self) -> None:
        require_positive(spacing_of_specks=self.spacing, radius_of_specks=self.radius)
        require_reflectance(self.reflectance, of="specks")
        if 2 * self.radius > self.spacing:
            raise InputError(
                f"Specks of radius {self.radius:g} m need a spacing of at least twice that, got {self.spacing:g} m."
            )

    def cover(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        around = max(int(2 * np.pi * nominal_radius / self.spacing), 1)
        size = 2 * np.pi * nominal_radius / around, self.spacing
        place = np.stack([np.mod(clock, 2 * np.pi) * nominal_radius / size[0], axial / self.spacing])
        cell = np.floor(place)
        which = (cell[0] % self._table.shape[1]).astype(np.intp), (cell[1] % CELLS_ALONG).astype(np.intp)
        reach, *offset = self._table[:, which[0], which[1]]
        radius = self.radius * (0.3 + 0.7 * reach)
        away = [(part - whole) * one for part, whole, one in zip(place, cell, size, strict=True)]
        centre = [radius + (one - 2 * radius) * shift for one, shift in zip(size, offset, strict=True)]
        distance = np.hypot(away[0] - centre[0], away[1] - centre[1])
        return smooth_step((radius - distance) / (0.3 * radius))

    @cached_property
    def _table(self) -> Array:
        """Size and place of the speck in every cell: (3, cells round, cells along), each from 0 to 1."""
        return np.random.default_rng(self.seed).random((3, 1024, CELLS_ALONG))


@dataclass(frozen=True)
class Deposit(WallPart):
    """The wall where a `patch` stands up from it."""

    patch: Patch

    def reshaped(self, radius: Array, axial: Array, clock: Array, nominal_radius: float) -> Array:
        return radius - self.patch.height * self.patch.cover(axial, clock, nominal_radius)

    def reach(self, nominal_radius: float) -> float:
        return self.patch.height

    def recess(self, nominal_radius: float) -> float:
        return 0.0

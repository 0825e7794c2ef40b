"""Surfaces whose place is known: what the light of a laser falls on while a rig is calibrated."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import fit_circle

Array = NDArray[np.float64]

U_TILT = np.radians(0.5)
"""Standard uncertainty of the slope of a target or gauge that was set up with care, with a square."""
FLAT = 0.02
"""A ring whose points' axial spread is less than this fraction of its radius is looked at as flat."""
MOST_TILTED = 3.0
"""A gauge starts at most this many standard uncertainties inclined."""
CENTRE, SLOPES = ("centre_x", "centre_y"), ("slope_x", "slope_y")
SQUARES = ("square_1", "square_2", "square_3")
OUTWARDS, AHEAD = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class Gap(NamedTuple):
    """`value` (n,) [m] of points beyond the surface, its derivatives `by_point` (n, 3) and `by_nuisance` (n, q)."""

    value: Array
    by_point: Array
    by_nuisance: Array


class Reference(ABC):
    """A surface in the rig frame, known but for the q numbers `nuisance_names` of the way it was set up.

    `nuisance_u` (q,): their standard uncertainties about 0 before any picture, infinite where nothing is known; `u`
    [m]: standard uncertainty of the stated size or place, which adds alike to the gap of all points; None: unstated,
    the scatter of the stops shall tell.
    """

    u: float | None

    def stating(self, u: float | None) -> Self:
        """This reference with another `u`; references are dataclasses."""
        return replace(self, u=u)  # type: ignore[type-var]

    @property
    @abstractmethod
    def nuisance_names(self) -> tuple[str, ...]: ...

    @property
    @abstractmethod
    def nuisance_u(self) -> Array: ...

    @abstractmethod
    def gap(self, points: Array, nuisance: Array) -> Gap:
        """How far `points` (n, 3) [m] lie beyond the surface, for `nuisance` (q,)."""

    def first_guess(self, points: Array) -> Array:
        """Where a search for the nuisance (q,) starts, from rough `points` (n, 3) on the surface."""
        return np.zeros(len(self.nuisance_names))

    def doubting(self, covariance: Array | None) -> Self:
        """This reference where its nuisance is known with `covariance` (q, q) only, or, None, as it was before: what
        gaps hold of its square, which is not 0 on average, counts.
        """
        return self


@dataclass(frozen=True)
class FlatTarget(Reference):
    """A flat at `distance` [m] from the rig's origin along the unit vector `direction`, one of the rig's axes; gaps
    are measured along it.

    `u_tilt`: standard uncertainties of its slopes along the two other axes of the rig, in their order, 0 where it is
    square to the direction.
    """

    distance: float
    direction: tuple[float, float, float] = OUTWARDS
    u: float | None = None
    u_tilt: tuple[float, float] = (U_TILT, U_TILT)

    def __post_init__(self) -> None:
        if not 0 < self.distance < np.inf:
            raise InputError(f"A flat target stands at a positive distance, got {self.distance} m.")
        _refuse_uncertainty(self.u, *self.u_tilt)

    @property
    def _inclined(self) -> tuple[int, ...]:
        """Axes of the rig along which its slope is unknown."""
        across = [axis for axis in range(3) if self.direction[axis] == 0]
        return tuple(axis for axis, u in zip(across, self.u_tilt, strict=True) if u > 0)

    @property
    def nuisance_names(self) -> tuple[str, ...]:
        return tuple(f"tilt_{'xyz'[axis]}" for axis in self._inclined)

    @property
    def nuisance_u(self) -> Array:
        return np.array([u for u in self.u_tilt if u > 0])

    def gap(self, points: Array, nuisance: Array) -> Gap:
        across = points[:, self._inclined]
        by_point = np.tile(np.array(self.direction), (len(points), 1))
        by_point[:, self._inclined] -= nuisance
        return Gap(points @ np.array(self.direction) - self.distance - across @ nuisance, by_point, -across)


@dataclass(frozen=True)
class RingGauge(Reference):
    """The inside of a round of `diameter` [m], its axis through an unknown centre `at` [m] ahead of the pupil and
    inclined by unknown slopes, whose standard uncertainty is `u_tilt`; `u` [m] is that of the radius.

    `doubt`: variances of the slopes about what was found and their covariance. A gauge seems smaller by half the square
    of a slope, in its plane, whatever its sign: by that on average, and by three unknown "squares" more, of its
    standard deviations (Isserlis).
    """

    diameter: float
    at: float = 0.0
    u: float | None = None
    u_tilt: float = U_TILT
    doubt: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not 0 < self.diameter < np.inf:
            raise InputError(f"The diameter of a ring gauge must be positive, got {self.diameter} m.")
        _refuse_uncertainty(self.u, self.u_tilt)

    @property
    def nuisance_names(self) -> tuple[str, ...]:
        if not self.u_tilt > 0:
            return CENTRE
        return (*CENTRE, *SLOPES) if self.doubt is None else (*CENTRE, *SLOPES, *SQUARES)

    @property
    def nuisance_u(self) -> Array:
        return np.array([np.inf, np.inf, self.u_tilt, self.u_tilt, 1.0, 1.0, 1.0][: len(self.nuisance_names)])

    def doubting(self, covariance: Array | None) -> Self:
        if covariance is None or not self.u_tilt > 0:
            return replace(self, doubt=None)
        (xx, xy), (_, yy) = covariance[2:4, 2:4].tolist()
        return replace(self, doubt=(xx, yy, xy))

    def gap(self, points: Array, nuisance: Array) -> Gap:
        """With w from a place on the axis a to the point: |w - (w . a) a| - diameter / 2, and what `doubt` adds."""
        axis = np.array([*(nuisance[2:4] if self.u_tilt > 0 else (0.0, 0.0)), 1.0])
        length = np.linalg.norm(axis)
        axis = axis / length
        arms = points - np.array([nuisance[0], nuisance[1], self.at])
        along = arms @ axis
        across = arms - along[:, None] * axis
        distance = np.linalg.norm(across, axis=1)
        outwards = across / distance[:, None]
        by_slope = -(along / length)[:, None] * outwards[:, :2]
        by_nuisance = np.concatenate([-outwards[:, :2], by_slope], axis=1)[:, : len(self.nuisance_names)]
        if self.doubt is None or not self.u_tilt > 0:
            return Gap(distance - self.diameter / 2, outwards, by_nuisance)
        mean, by_squares = self._squares(outwards)
        value = distance - self.diameter / 2 + mean + by_squares @ nuisance[4:]
        return Gap(value, outwards, np.concatenate([by_nuisance, by_squares], axis=1))

    def _squares(self, outwards: Array) -> tuple[Array, Array]:
        """Mean (n,) and standard deviations (n, 3) of what the square of the slopes' errors adds to gaps."""
        assert self.doubt is not None
        xx, yy, xy = self.doubt
        x, y = outwards[:, 0], outwards[:, 1]
        by_products = -self.diameter / 4 * np.stack([x**2, y**2, 2 * x * y], axis=1)
        spread = [[2 * xx**2, 2 * xy**2, 2 * xx * xy], [0.0, 2 * yy**2, 2 * yy * xy], [0.0, 0.0, xx * yy + xy**2]]
        strength, axes = np.linalg.eigh(np.array(spread), UPLO="U")
        return by_products @ [xx, yy, xy], by_products @ (axes * np.sqrt(np.maximum(strength, 0.0)))

    def first_guess(self, points: Array) -> Array:
        """The centre of the circle; where the ring is flat, the inclination that would make its ellipse: the first
        derivative by the inclination of a ring square to its gauge is 0, so that a search could not leave it.
        """
        guess = np.zeros(len(self.nuisance_names))
        try:
            circle = fit_circle(points[:, :2], robust=True)
        except InputError:  # an arc too short to tell: in the middle, then
            return guess
        guess[:2] = circle.centre
        if self.u_tilt > 0 and np.std(points[:, 2]) < FLAT * circle.radius:
            x, y = (points[:, :2] - circle.centre).T
            turn = 2 * np.arctan2(y, x)
            waves = np.stack([np.cos(turn), np.sin(turn)], axis=1)
            (c, s), *_ = np.linalg.lstsq(waves, np.hypot(x, y) - circle.radius)
            size = min(2 * np.sqrt(np.hypot(c, s) / circle.radius), MOST_TILTED * self.u_tilt)
            guess[2:] = size * np.cos(np.arctan2(s, c) / 2), size * np.sin(np.arctan2(s, c) / 2)
        return guess


def _refuse_uncertainty(*values: float | None) -> None:
    if not all(value is None or 0 <= value < np.inf for value in values):
        raise InputError(f"Standard uncertainties must not be negative, got {', '.join(map(str, values))}.")

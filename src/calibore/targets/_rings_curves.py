"""Smooth curves in a picture, rings and spokes: place, direction and curvature, and the foot of any pixel on them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._rings_spokes import DEGREE, Spoke

Array = NDArray[Any]

HARMONICS = 28
"""Of the radius over the azimuth: an eccentric circle needs ln(0.01 px / R) / ln(eccentricity) of them."""
STIFFNESS = 1e-6
"""Penalty on n^4, per data point: bridges gaps (a ring cut by the picture's edge) without waves."""
TABLE_STEP = 0.5
"""px between the places tabulated along a curve."""
FOOT_STEPS = 3
TABULATED = 8192
"""Places round the azimuth at which a function is tabulated: a radius within 1e-3 px."""
MEETING_SIGMA = 0.1
"""px: how well it is known where the spokes meet."""
OUTLYING, NORMAL, LEAST_SCATTER = 4.0, 1.4826, 1e-4
"""Standard deviations beyond which data hardly bend a curve; standard deviation over median deviation; px."""
ROUNDS = 4
"""Of weighting outliers down."""


@dataclass(frozen=True, eq=False)
class Round:
    """A smooth function of the azimuth: `coefficients` (1 + 2 n,) of 1, cos, sin, cos 2, sin 2, ..."""

    coefficients: Array

    def __call__(self, azimuth: Array) -> Array:
        """Value (n,)."""
        return self._interpolated(azimuth, self._tables[:1])[0]

    def derivatives(self, azimuth: Array) -> tuple[Array, Array, Array]:
        """Value, first and second derivative (n,) by the azimuth."""
        value, slope, bend = self._interpolated(azimuth, self._tables)
        return value, slope, bend

    def _interpolated(self, azimuth: Array, tables: Array) -> Array:
        place = np.asarray(azimuth) * (TABULATED / (2 * np.pi)) % TABULATED
        whole = place.astype(np.intp)
        return tables[:, whole] + (place - whole) * (tables[:, whole + 1] - tables[:, whole])

    @cached_property
    def _tables(self) -> Array:
        """Value and derivatives (3, TABULATED + 2) once round and a little on."""
        waves = np.zeros((3, TABULATED // 2 + 1), dtype=complex)
        order = np.arange(self.coefficients.size // 2 + 1)
        waves[0, 1 : order.size] = (self.coefficients[1::2] - 1j * self.coefficients[2::2]) / 2
        waves[0, 0] = self.coefficients[0]
        waves[1, : order.size], waves[2, : order.size] = (waves[0, : order.size] * (1j * order) ** n for n in (1, 2))
        tables = np.fft.irfft(waves, n=TABULATED) * TABULATED
        return np.concatenate([tables, tables[:, :2]], axis=1)


def harmonics(azimuth: Array, count: int) -> Array:
    """Columns (n, 1 + 2 count): 1, cos, sin, cos 2, sin 2, ... of the azimuth."""
    turns = np.outer(azimuth, np.arange(1, count + 1))
    columns = np.empty((azimuth.size, 1 + 2 * count))
    columns[:, 0], columns[:, 1::2], columns[:, 2::2] = 1, np.cos(turns), np.sin(turns)
    return columns


def fit_round(
    azimuth: Array, values: Array, *, weight: Array | None = None, count: int = HARMONICS, stiffness: float = STIFFNESS
) -> Round:
    """A smooth function through `values` (n,) at `azimuth` (n,) with `weight` (n,), outliers weighing little."""
    design = harmonics(azimuth, count)
    trust = np.ones(values.shape) if weight is None else weight
    order = np.concatenate([[0.0], np.repeat(np.arange(1.0, count + 1), 2)])
    penalty = np.diag(stiffness * trust.sum() * order**4)
    robust, coefficients = np.ones(values.shape), np.zeros(order.size)
    for _ in range(ROUNDS):
        weighted = design * (trust * robust)[:, None]
        coefficients = np.linalg.solve(weighted.T @ design + penalty, weighted.T @ values)
        residual = values - design @ coefficients
        scatter = NORMAL * np.median(np.abs(residual)) + LEAST_SCATTER
        robust = 1 / (1 + (residual / (OUTLYING * scatter)) ** 4)
    return Round(coefficients)


@dataclass(frozen=True, eq=False)
class Curve:
    """Tabulated at m places: `point` (m, 2) [px], unit `normal` (m, 2), `speed` (m,) [px per place], `bend` (m,) [1/px]
    (positive where the centre of curvature lies against the normal), length `arc` (m,) [px] up to each place, and
    the `parameter` (m,) of the places: azimuth [rad] of a ring, `closed`, or distance [px] along a spoke; both count
    from the `centre` (2,).
    """

    centre: Array
    point: Array
    normal: Array
    speed: Array
    bend: Array
    arc: Array
    parameter: Array
    closed: bool

    def at(self, table: Array, index: Array) -> Array:
        """`table` (m, ...) between its places, linearly; an open curve ends at its ends."""
        size = len(table)
        whole = np.floor(index).astype(np.intp)
        whole = whole % size if self.closed else np.clip(whole, 0, size - 2)
        part = index - np.floor(index) if self.closed else index - whole
        nearby = (whole + 1) % size
        part = part.reshape(part.shape + (1,) * (table.ndim - 1))
        return table[whole] + part * (table[nearby] - table[whole])

    def parameter_at(self, index: Array) -> Array:
        """The parameter (n,) of an index."""
        return self.parameter[0] + index * (self.parameter[1] - self.parameter[0])

    def start(self, places: Array) -> Array:
        """About which index (n,) the feet of `places` (n, 2) have."""
        offset = places - self.centre
        if self.closed:
            return np.arctan2(offset[:, 1], offset[:, 0]) % (2 * np.pi) / self.parameter[1]
        chord = self.point[-1] - self.point[0]
        along = offset @ (chord / np.hypot(*chord))
        return (along - self.parameter[0]) / (self.parameter[1] - self.parameter[0])

    def foot(self, places: Array, index: Array) -> tuple[Array, Array]:
        """Index of the nearest place of the curve, and distance [px] along its normal, of `places` (n, 2)."""
        for _ in range(FOOT_STEPS):
            near = self.at(self._approach, index)
            index = index + np.einsum("ni,ni->n", places - near[:, :2], near[:, 2:])
        near = self.at(self._across, index)
        return index, np.einsum("ni,ni->n", places - near[:, :2], near[:, 2:])

    @cached_property
    def _approach(self) -> Array:
        """Points and tangents over the speed (m, 4). A ring's normal points outwards, a spoke's to growing azimuth; the
        tangent of both to growing places.
        """
        handed = -1.0 if self.closed else 1.0
        tangent = handed * np.stack([self.normal[:, 1], -self.normal[:, 0]], axis=1) / self.speed[:, None]
        return np.concatenate([self.point, tangent], axis=1)

    @cached_property
    def _across(self) -> Array:
        return np.concatenate([self.point, self.normal], axis=1)

    @property
    def length(self) -> float:
        return float(self.arc[-1] + (self.speed[-1] if self.closed else 0.0))


def ring_curve(centre: Array, radius: Round) -> Curve:
    """The closed curve at `radius` [px] of the azimuth round the centre; its normal points outwards."""
    coarse = radius(np.linspace(0, 2 * np.pi, 256, endpoint=False))
    azimuth = np.arange(int(np.ceil(2 * np.pi * coarse.max() / TABLE_STEP))) * 1.0
    step = 2 * np.pi / azimuth.size
    azimuth *= step
    r, slope, second = radius.derivatives(azimuth)
    outward = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    turned = np.stack([-outward[:, 1], outward[:, 0]], axis=1)
    speed = np.hypot(r, slope)
    normal = (r[:, None] * outward - slope[:, None] * turned) / speed[:, None]
    bend = (r * r + 2 * slope * slope - r * second) / speed**3
    arc = np.concatenate([[0.0], np.cumsum(speed * step)[:-1]])
    return Curve(centre, centre + r[:, None] * outward, normal, speed * step, bend, arc, azimuth, True)


def spoke_curve(spoke: Spoke, first: float, last: float) -> Curve:
    """The open curve along a spoke from the distance `first` to `last` [px]; its normal points to growing azimuth."""
    distance = np.arange(first, last, TABLE_STEP)
    polynomial = np.polynomial.polynomial
    slope = polynomial.polyval(distance, polynomial.polyder(spoke.coefficients))
    second = polynomial.polyval(distance, polynomial.polyder(spoke.coefficients, 2))
    speed = np.sqrt(1 + slope**2)
    normal = (spoke.across - slope[:, None] * spoke.along) / speed[:, None]
    arc = np.concatenate([[0.0], np.cumsum(speed * TABLE_STEP)[:-1]])
    return Curve(
        spoke.centre, spoke.points(distance), normal, speed * TABLE_STEP, -second / speed**3, arc, distance, False
    )


def refitted(spoke: Spoke, places: Array, sigma: Array, *, meeting: Array) -> Spoke:
    """The spoke through measured `places` (n, 2) [px] with `sigma` (n,) [px] and the `meeting` (2,) of all spokes."""
    s, t = spoke.coordinates(np.concatenate([[meeting], places]))
    sigma = np.concatenate([[MEETING_SIGMA], sigma])
    reach = float(s.max())
    design = np.vander(s / reach, DEGREE + 1, increasing=True) / sigma[:, None]
    weight, solution = np.ones(s.shape), np.zeros(DEGREE + 1)
    for _ in range(ROUNDS):
        solution = np.linalg.lstsq(design * weight[:, None], t / sigma * weight, rcond=None)[0]
        weight = 1 / (1 + ((t / sigma - design @ solution) / OUTLYING) ** 2)
        weight[0] = 1.0
    return Spoke(spoke.centre, spoke.azimuth, solution / reach ** np.arange(DEGREE + 1), spoke.length)

"""One region of change: where it is, how large, how deep, how much is gone."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._difference import LEAST_SCATTER, Difference
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

AROUND = 2.0
"""Times its own extent, to each side: how far around a region its shape is fitted."""
FEWEST_RINGS = 2
"""On which a region must lie, with another beside it, for its extent along the pipe to be told."""
LEAST_WIDTH = 1.0
"""Steps of the grid: narrowest shape that is fitted."""


@dataclass(frozen=True, eq=False)
class Region:
    """`cells` (n, m) of the difference; `axial` [m], `clock` [rad] of its middle; `area` [m2] of wall; `depth` [m] of
    the change at its deepest, between rings too where it lies on several; `mean` [m], `volume` [m3]. Positive: the
    radius has grown. `measured_depth` [m]: of the deepest single point; `shaped`: whether depth and place are
    those of a bell fitted to the region, else of its points.
    """

    cells: Mask
    axial: Quantity
    clock: Quantity
    area: float
    depth: Quantity
    mean: Quantity
    volume: Quantity
    measured_depth: Quantity
    shaped: bool

    @property
    def points(self) -> int:
        return int(np.count_nonzero(self.cells))


class _Bell(NamedTuple):
    """A Gaussian bell: `values` depth [m], axial place [m], clock [rad], widths [m], [rad]; their `covariance`."""

    values: Array
    covariance: Array


def region_of(difference: Difference, cells: Mask) -> Region:
    """The region of the points `cells` (n, m)."""
    value, area = difference.adjusted, _areas(difference)
    weight = np.where(cells & np.isfinite(value), area, 0.0)
    change = np.nan_to_num(value)
    total, volume = weight.sum(), float(np.sum(weight * change))
    u_volume = _u_of_sum(difference, weight)
    deepest = np.unravel_index(int(np.argmax(np.where(cells, np.abs(change), -1))), cells.shape)
    single = Quantity(float(change[deepest]), float(difference.u_adjusted[deepest]))
    bell = _bell(difference, cells, Quantity(volume / total, u_volume / total))
    if bell is None:
        share = np.abs(weight * change)
        share = share / share.sum()
        axial, clock = float(np.sum(share * np.nan_to_num(difference.axial))), _mean_clock(difference.clock, share)
        spread_axial, spread_clock = _spread(difference, share, axial, clock)
        places = Quantity(axial, spread_axial), Quantity(clock, spread_clock)
    else:
        u = np.sqrt(np.diag(bell.covariance))
        places = (
            Quantity(float(bell.values[1]), float(u[1])),
            Quantity(float(bell.values[2] % (2 * np.pi)), float(u[2])),
        )
    depth = single if bell is None else Quantity(float(bell.values[0]), float(np.sqrt(bell.covariance[0, 0])))
    mean = Quantity(volume / total, u_volume / total)
    return Region(
        cells, *places, float(total), depth, mean, Quantity(volume, u_volume), single, shaped=bell is not None
    )


def _areas(difference: Difference) -> Array:
    """(n, m) [m2] of wall that each point stands for: half-way to its neighbours."""
    axial = np.nanmedian(difference.axial, axis=1)
    length = np.abs(np.gradient(axial)) if axial.size > 1 else np.full(1, np.nan)
    if axial.size == 1:
        length = np.full(1, float(np.nanmedian(difference.radius)) * 2 * np.pi / difference.value.shape[1])
    return length[:, None] * np.nan_to_num(difference.radius) * (2 * np.pi / difference.value.shape[1])


def _u_of_sum(difference: Difference, weight: Array) -> float:
    """Of the sum of weighted changes: noise with its correlation along the clock, and common errors."""
    registration = difference.registration
    part = weight * np.nan_to_num(difference.u_independent) * max(registration.scatter, LEAST_SCATTER)
    variance = float(np.sum(part**2))
    for lag, shared in enumerate(registration.correlation.tolist(), start=1):
        variance += 2 * shared * float(np.sum(part * np.roll(part, lag, axis=1)))
    common = np.tensordot(np.nan_to_num(difference.adjusted_modes), weight, axes=2)
    missed = np.sum(weight * np.nan_to_num(difference.missed), axis=1)
    return float(np.sqrt(max(variance, 0.0) + np.sum(common**2) + np.sum(missed**2)))


def _mean_clock(clock: Array, share: Array) -> float:
    clock = np.nan_to_num(clock)
    return float(np.arctan2(np.sum(share * np.sin(clock)), np.sum(share * np.cos(clock))) % (2 * np.pi))


def _spread(difference: Difference, share: Array, axial: float, clock: float) -> tuple[float, float]:
    """Standard uncertainties of a place that is the middle of points: their spacing, and how little they differ."""
    worth = max(float(1 / np.sum(share**2)), 1.0)
    aside = np.mod(np.nan_to_num(difference.clock) - clock + np.pi, 2 * np.pi) - np.pi
    along = np.sqrt(np.sum(share * (np.nan_to_num(difference.axial) - axial) ** 2) / worth)
    step = np.abs(np.gradient(np.nanmedian(difference.axial, axis=1))).max() if len(difference.axial) > 1 else 0.0
    around = np.sqrt(np.sum(share * aside**2) / worth)
    return float(np.hypot(along, step / np.sqrt(12))), float(np.hypot(around, 2 * np.pi / aside.shape[1] / np.sqrt(12)))


def _bell(difference: Difference, cells: Mask, mean: Quantity) -> _Bell | None:
    """A bell that fits the region and its surroundings; None where it lies on too few rings or does not fit."""
    from scipy.optimize import least_squares

    if np.count_nonzero(cells.any(axis=1)) < FEWEST_RINGS or len(cells) <= FEWEST_RINGS:
        return None
    z, c, known = difference.axial, difference.clock, np.isfinite(difference.adjusted)
    middle = _mean_clock(c, np.where(cells & known, 1.0, 0.0))
    aside = np.mod(np.nan_to_num(c) - middle + np.pi, 2 * np.pi) - np.pi
    spacing = float(np.median(np.abs(np.diff(np.nanmedian(z, axis=1)))))
    half = (
        max(float(np.ptp(z[cells & known])) / 2, spacing),
        max(float(np.ptp(aside[cells & known])) / 2, 2 * np.pi / cells.shape[1]),
    )
    centre = float(np.mean(z[cells & known]))
    near = known & (np.abs(aside) <= (1 + AROUND) * half[1])
    near &= np.abs(np.nan_to_num(z) - centre) <= (1 + AROUND) * half[0] + spacing
    zs, cs, value, u = z[near], aside[near], difference.adjusted[near], difference.u_adjusted[near]

    def shape(p: Array) -> Array:
        bell = p[0] * np.exp(-0.5 * ((zs - p[1]) / p[3]) ** 2 - 0.5 * ((cs - p[2]) / p[4]) ** 2)
        return (bell - value) / u

    least = np.array([LEAST_WIDTH * spacing / 2, LEAST_WIDTH * 2 * np.pi / cells.shape[1]])
    start = [1.5 * mean.value, centre, 0.0, max(half[0], 1.01 * least[0]), max(half[1] / 2, 1.01 * least[1])]
    wide = [np.inf, (1 + AROUND) * half[0] + spacing, (1 + AROUND) * half[1]]
    lower = [-np.inf, centre - wide[1], -wide[2], *least]
    upper = [np.inf, centre + wide[1], wide[2], 10 * half[0] + spacing, np.pi]
    found = least_squares(shape, start, bounds=(lower, upper), x_scale=[abs(start[0]), spacing, 0.1, spacing, 0.1])
    chi = 2 * found.cost / max(value.size - 5, 1)
    rank = np.linalg.matrix_rank(found.jac / np.linalg.norm(found.jac, axis=0))
    if not found.success or rank < 5 or np.sign(found.x[0]) != np.sign(mean.value):
        return None
    effect = max(1 + 2 * float(difference.registration.correlation.sum()), 1.0)
    covariance = np.linalg.inv(found.jac.T @ found.jac) * max(chi, 1.0) * effect
    return _Bell(found.x + np.array([0, 0, middle, 0, 0]), covariance)

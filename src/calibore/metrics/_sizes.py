"""Means, sizes, extremes and the second harmonic of the estimated wall, in units of its scale, each with its u."""

import numpy as np
from numpy.typing import NDArray

from calibore.metrics import _definitions as definitions
from calibore.metrics._draws import WallGrid

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SIGNIFICANT = 2.0
LINEAR = ("diameter_mean", "area", "diameter_equivalent_area", "perimeter", "diameter_horizontal", "diameter_vertical")
OVALITIES = ("ovality_f1216_max", "ovality_f1216_min", "ovality_range", "ovality_harmonic")
EXTREMES = ("diameter_min", "diameter_max", *OVALITIES[:3])


def corrected_extremes(grid: WallGrid, both: Mask) -> dict[str, tuple[float, float]]:
    """Value and uncertainty of every extreme of the diameters, noise bias removed, in units of the wall's scale."""
    diameters, again, possible = (grid.diameters(which) for which in ("best", "again", "possible"))
    best = _extremes(diameters, both)
    value = best - (_extremes(again, both).mean(axis=1, keepdims=True) - best)
    value[2:] = np.maximum(value[2:], 0.0)
    spread = np.mean((_extremes(possible, both) - value) ** 2, axis=1)
    hidden = 0.0 if both.all() else _extremes(diameters, np.ones_like(both)) - best
    taken = _extremes(grid.diameters("freed"), both) - best
    u_mean = 2 * np.sqrt(np.sum(grid.edges.sum(axis=0) ** 2)) / grid.regular / diameters.mean()
    through_mean = u_mean * np.array([0.0, 0.0, 100.0, 100.0, value[4, 0]])
    u = np.sqrt(spread + (hidden**2 + taken**2)[:, 0] + through_mean**2)
    return dict(zip(EXTREMES, zip(value[:, 0].tolist(), u.tolist(), strict=True), strict=True))


def _extremes(diameters: Array, both: Mask) -> Array:
    """The EXTREMES (5, b) of diameters (b, d) over directions measured at `both` ends (d,)."""
    mean = diameters.mean(axis=1)
    seen = diameters if both.all() else diameters[:, both]
    least, most = (seen.min(axis=1), seen.max(axis=1)) if both.any() else (mean * np.nan, mean * np.nan)
    return np.stack([least, most, 100 * (most / mean - 1), 100 * (1 - least / mean), 100 * (most - least) / mean])


def second_harmonic(grid: WallGrid) -> dict[str, tuple[float, float]]:
    """ovality_harmonic of the estimated wall; what was taken off its amplitude as noise counts as uncertainty."""
    n = grid.regular
    angle = 4 * np.pi * np.arange(n) / n
    project = 2 / n * np.stack([np.cos(angle), np.sin(angle)])
    free, value = project @ grid.freed[:n], float(np.hypot(*(project @ grid.best[:n])))
    walls, mean = np.column_stack([grid.possible, grid.edges])[:n], float(grid.best[:n].mean())
    factors = project @ walls - np.outer(free, walls.mean(axis=0)) / mean
    covariance = factors @ factors.T
    largest, size = float(np.linalg.eigvalsh(covariance)[-1]), float(np.hypot(*free))
    along = float(free @ covariance @ free) / size**2 if size > SIGNIFICANT * np.sqrt(largest) else largest
    unit = 100 / mean
    return {"ovality_harmonic": (value * unit, float(np.sqrt(along + (size - value) ** 2)) * unit)}


def linear_sizes(grid: WallGrid) -> dict[str, tuple[float, float]]:
    """Value and uncertainty of means, sizes and single diameters: exact linear sensitivities to the wall."""
    n = grid.regular
    turn = grid.best[:n]
    rows = np.zeros((6, grid.best.size))
    wall_area = float(definitions.area(turn))
    equivalent = float(definitions.diameter_equivalent_area(wall_area))
    rows[0, :n] = 2 / n
    rows[1, :n] = 2 * np.pi * turn / n
    rows[2] = rows[1] * equivalent / (2 * wall_area)
    rows[3, :n] = definitions.perimeter_gradient(turn)
    rows[4, n : n + 2] = rows[5, n + 2 :] = 1.0
    values = [2 * turn.mean(), wall_area, equivalent, definitions.perimeter(turn), *(rows[4:] @ grid.best)]
    u = np.sqrt(np.sum((rows @ np.column_stack([grid.possible, grid.edges])) ** 2, axis=1))
    return {name: (float(v), float(w)) for name, v, w in zip(LINEAR, values, u, strict=True)}

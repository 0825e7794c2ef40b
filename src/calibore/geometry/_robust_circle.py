"""A circle that foreign points do not pull: least median of squares, then iteratively re-weighted distances."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry._orthogonal import CONVERGED, checked, distances_with_jacobian, gauss_newton_step

Array = NDArray[Any]

TUKEY_TUNING = 4.685  # standard deviations; 95 % efficiency on normal noise (Holland and Welsch 1977)
TUKEY_EFFICIENCY = 0.95
MEDIAN_TO_DEVIATION = 1.4826  # median of |x| to standard deviation of normal x
SCALE_STEPS = 5  # the scale follows the residuals for so many steps, then rests so that the fit can settle
STEPS = 40
ROBUST_CONVERGED = 1e-9  # of the extent of the points
SCORED_POINTS = 150  # enough for a median
SPREADS = ((1 / 3, 2 / 3), (1 / 4, 1 / 2), (1 / 4, 3 / 4), (1 / 6, 1 / 2))  # of the way round, from the first point
TRIPLES_PER_SPREAD = 16
RANDOM_TRIPLES = 64


class RobustCircle(NamedTuple):
    """`variance`: residual variance of unit weight by Huber (1981, section 7.6), NaN without a spare point."""

    circle: Array
    carried: NDArray[np.bool_]
    variance: float


def robust_circle(points: Array, weights: Array) -> RobustCircle:
    """Tukey's biweight from the least-median circle; `weights` (n,) are inverse variances, `points` of unit extent."""
    circle, root = _least_median(points, np.sqrt(weights)), np.sqrt(weights)
    floor, scale = CONVERGED * float(root.max()), 0.0
    for iteration in range(STEPS):
        distances, jacobian = distances_with_jacobian(circle, points)
        if iteration < SCALE_STEPS:
            scale = max(MEDIAN_TO_DEVIATION * float(np.median(np.abs(distances * root))), floor)
        step = gauss_newton_step(jacobian, weights * _tukey(distances * root / scale), distances)
        circle = checked(circle + step)
        if iteration >= SCALE_STEPS and np.abs(step).max() <= ROBUST_CONVERGED:
            break
    standardised = distances_with_jacobian(circle, points)[0] * root / scale
    return RobustCircle(circle, _tukey(standardised) > 0, scale**2 * _huber_variance(standardised))


def _tukey(standardised: Array) -> Array:
    return np.maximum(1 - (standardised / TUKEY_TUNING) ** 2, 0.0) ** 2


def _huber_variance(standardised: Array) -> float:
    weights = _tukey(standardised)
    carried = weights > 0
    spare = int(carried.sum()) - 3
    if spare < 0:
        raise InputError("Fewer than 3 points agree on one circle; fit without robust=True or add points.")
    relative = (standardised[carried] / TUKEY_TUNING) ** 2
    slope = float(np.mean((1 - relative) * (1 - 5 * relative)))
    return float(np.sum((weights * standardised) ** 2)) / spare / slope**2 if spare else np.nan


def _least_median(points: Array, root_weights: Array) -> Array:
    """The circle through three points with the least median distance (Rousseeuw 1984), over a fixed set of triples."""
    circles = _through(points[_triples(points)])
    some = np.linspace(0, len(points) - 1, min(len(points), SCORED_POINTS)).astype(int)
    x, y, root = points[some, 0], points[some, 1], root_weights[some]
    length = np.sqrt((x - circles[:, :1]) ** 2 + (y - circles[:, 1:2]) ** 2)
    apart, middle = np.abs(length - circles[:, 2:]) * root, len(some) // 2
    return circles[np.argmin(np.partition(apart, middle, axis=1)[:, middle])]


def _triples(points: Array) -> NDArray[np.intp]:
    """Indices (m, 3): evenly spread round the ring, and some drawn with a fixed seed (same input, same bytes)."""
    n = len(points)
    centre = np.median(points, axis=0)
    order = np.argsort(np.arctan2(points[:, 0] - centre[0], centre[1] - points[:, 1]), kind="stable")
    first = np.linspace(0, n, TRIPLES_PER_SPREAD, endpoint=False)
    spread = [np.stack([first, first + b * n, first + c * n], axis=1) for b, c in SPREADS]
    return order[np.concatenate([np.concatenate(spread).astype(np.intp) % n, drawn_triples(n)])]


@lru_cache(maxsize=64)
def drawn_triples(n: int) -> NDArray[np.int64]:
    """Indices (m, 3) of triples of `n` points, the same every time."""
    return np.random.default_rng(0).integers(0, n, (RANDOM_TRIPLES, 3))


def _through(triples: Array) -> Array:
    """Circles (m, 3) through triples (m, 3, 2) of points; those of collinear triples are left out."""
    origin = triples[:, 0]
    (bx, by), (cx, cy) = (triples[:, 1] - origin).T, (triples[:, 2] - origin).T
    doubled_area = 2 * (bx * cy - by * cx)
    good = np.abs(doubled_area) > np.finfo(float).eps
    bx, by, cx, cy, doubled_area = bx[good], by[good], cx[good], cy[good], doubled_area[good]
    if not good.any():
        raise InputError("The points are too close to one line to determine a circle; add points or more arc.")
    b_square, c_square = bx**2 + by**2, cx**2 + cy**2
    x, y = (cy * b_square - by * c_square) / doubled_area, (bx * c_square - cx * b_square) / doubled_area
    return np.column_stack([x + origin[good, 0], y + origin[good, 1], np.sqrt(x**2 + y**2)])

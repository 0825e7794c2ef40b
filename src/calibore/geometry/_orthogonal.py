"""The least sum of squared orthogonal distances to a circle (x, y, radius), on points scaled to unit extent."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[Any]

STEPS = 100
CONVERGED = 1e-13  # of the extent of the points: rounding
COST_ROUNDING = 1 + 1e-12  # near the end a good step changes the cost by less than its rounding
LIGHT = 0.1  # damping above which a small step says nothing about the distance to the end
LARGEST_RADIUS = 1e7  # in extents of the points; beyond, the sagitta is lost in rounding


def algebraic_circle(points: Array) -> Array:
    """Taubin (1991) in the moment form of Chernov (2010, section 5.9): a start, biased on short arcs."""
    square = (points**2).sum(axis=1)
    mean_square = square.mean()
    columns = np.column_stack([(square - mean_square) / (2 * np.sqrt(mean_square)), points])
    a, b, c = np.linalg.eigh(columns.T @ columns)[1][:, 0]
    a = max(abs(a), 1.0 / LARGEST_RADIUS) * np.copysign(1.0, a) / (2 * np.sqrt(mean_square))
    return np.array([-b / (2 * a), -c / (2 * a), np.sqrt(b * b + c * c + 4 * a * a * mean_square) / (2 * abs(a))])


def distances_with_jacobian(circle: Array, points: Array) -> tuple[Array, Array]:
    """Orthogonal distances (n,), positive outside, and their derivatives (n, 3) with respect to (x, y, radius)."""
    offset = points - circle[:2]
    length = np.sqrt((offset**2).sum(axis=1))
    jacobian = np.empty((len(points), 3))
    jacobian[:, :2] = -offset / np.maximum(length, np.finfo(float).tiny)[:, None]
    jacobian[:, 2] = -1.0
    return length - circle[2], jacobian


def gauss_newton_step(jacobian: Array, weights: Array, distances: Array, *, damping: float = 0.0) -> Array:
    weighted = jacobian.T * weights
    normal = weighted @ jacobian
    if damping:
        normal[np.diag_indices(3)] *= 1 + damping
    try:
        return np.linalg.solve(normal, -weighted @ distances)
    except np.linalg.LinAlgError as error:
        raise InputError("The points do not determine a circle; add points or more arc.") from error


def least_squares_circle(points: Array, weights: Array) -> Array:
    """Levenberg-Marquardt; the damping stays zero as long as Gauss-Newton steps improve."""
    circle, damping = algebraic_circle(points), 0.0
    distances, jacobian = distances_with_jacobian(circle, points)
    cost = weights @ distances**2
    for _ in range(STEPS):
        step = gauss_newton_step(jacobian, weights, distances, damping=damping)
        trial = circle + step
        trial_distances, trial_jacobian = distances_with_jacobian(trial, points)
        trial_cost = weights @ trial_distances**2
        settled = damping < LIGHT and np.abs(step).max() <= CONVERGED * max(1.0, circle[2])
        if trial_cost <= cost * COST_ROUNDING or settled:
            circle, distances, jacobian, cost = trial, trial_distances, trial_jacobian, trial_cost
            damping = damping / 10 if damping > 1e-9 else 0.0
        else:
            damping = max(10 * damping, 1e-4)
        if settled:
            return checked(circle)
    raise InputError("The circle fit did not settle: the points hardly determine a circle; add points or more arc.")


def checked(circle: Array) -> Array:
    if not 0 < circle[2] < LARGEST_RADIUS:
        raise InputError("The points are too close to one line to determine a circle; add points or more arc.")
    return circle

"""How far the meetings of rays with a cone are from ceasing to exist."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.lasers._cone_meetings import dot, quadratic_along
from calibore.lasers._flat import RECEDING

FOLDING = 1.0  # distance = middle -+ root of the discriminant: its relative second-order term is 1 / (4 margin)
SECOND_ORDER = np.array([[FOLDING, FOLDING], [0.0, RECEDING], [RECEDING, 0.0]])


class ConeFrontiers(NamedTuple):
    """`value`, `by_half_angle` (3, n); `by_arm`, `by_direction`, `by_axis` (3, n, 3); `second_order` (3, 2)."""

    value: NDArray[Any]
    by_arm: NDArray[Any]
    by_direction: NDArray[Any]
    by_axis: NDArray[Any]
    by_half_angle: NDArray[Any]
    second_order: NDArray[np.float64]


def frontiers_of_cone(
    arms: NDArray[Any], directions: NDArray[Any], *, axis: NDArray[Any], half_angle: Any
) -> ConeFrontiers:
    """Rows: the ray touches the cone; its far meeting, and its near one, recede to infinity along a generator."""
    touching = _touching(arms, directions, axis, half_angle)
    running = _running_along(arms, directions, axis, half_angle)
    half_linear = np.real(quadratic_along(arms, directions, axis=axis, half_angle=half_angle).half_linear)
    rows = [touching, _unless(half_linear < 0, -1.0, running), _unless(half_linear > 0, 1.0, running)]
    value, by_arm, by_direction, by_axis, by_half_angle = (np.stack(parts) for parts in zip(*rows, strict=True))
    return ConeFrontiers(value, by_arm, by_direction, by_axis, by_half_angle, SECOND_ORDER)


def _touching(arms: NDArray[Any], directions: NDArray[Any], axis: NDArray[Any], half_angle: Any) -> tuple[Any, ...]:
    """The discriminant of Swanbom 2007, eq. 3-32, corrected, for any origin: free of the length of the arm."""
    normal = np.cross(arms, directions)
    lean = normal @ axis
    vector = np.sin(half_angle) ** 2 * normal - lean[:, None] * axis
    square = dot(arms, arms)
    value = dot(normal, vector) / square
    by_arm = 2 * (np.cross(directions, vector) - value[:, None] * arms) / square[:, None]
    by_direction = 2 * np.cross(vector, arms) / square[:, None]
    by_axis = -2 * (lean / square)[:, None] * normal
    return value, by_arm, by_direction, by_axis, np.sin(2 * half_angle) * dot(normal, normal) / square


def _running_along(
    arms: NDArray[Any], directions: NDArray[Any], axis: NDArray[Any], half_angle: Any
) -> tuple[Any, ...]:
    """The denominator of Swanbom 2007, eq. 3-31: 0 where the ray is parallel to a generator."""
    square_cosine, along, length = np.cos(half_angle) ** 2, directions @ axis, dot(directions, directions)
    by_direction = 2 * (along[:, None] * axis - square_cosine * directions)
    by_half_angle = np.sin(2 * half_angle) * length
    value = along**2 - square_cosine * length
    return value, np.zeros_like(by_direction), by_direction, 2 * along[:, None] * directions, by_half_angle


def _unless(unconcerned: NDArray[np.bool_], sign: float, row: tuple[Any, ...]) -> tuple[Any, ...]:
    """`sign` times the row; infinitely far, with slopes 0, for the rays it does not concern."""
    value, *slopes = row
    kept = (np.where(unconcerned.reshape(-1, *(1,) * (slope.ndim - 1)), 0, sign * slope) for slope in slopes)
    return np.where(unconcerned, np.inf, sign * value), *kept

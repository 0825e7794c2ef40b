"""How far the meetings of rays with a cone are from ceasing to exist."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.lasers._cone_meetings import dot, quadratic_along
from calibore.lasers._flat import RECEDING

FOLDING = 1.0  # distance = middle -+ root of the discriminant: its relative second-order term is 1 / (4 margin)
SECOND_ORDER = np.array([[FOLDING, FOLDING], [0.0, -RECEDING], [RECEDING, 0.0]])
"""Near and far differ in sign: towards the fold one effect adds to the other, or compensates it."""
FOLDS = np.array([True, False, False])


class ConeFrontiers(NamedTuple):
    """`value`, `by_half_angle` (3, n); `by_arm`, `by_direction`, `by_axis` (3, n, 3)."""

    value: NDArray[Any]
    by_arm: NDArray[Any]
    by_direction: NDArray[Any]
    by_axis: NDArray[Any]
    by_half_angle: NDArray[Any]


def frontiers_of_cone(
    arms: NDArray[Any], directions: NDArray[Any], *, axis: NDArray[Any], half_angle: Any
) -> ConeFrontiers:
    """Rows: the ray touches the cone; its far meeting, and its near one, recede to infinity along a generator.

    With Q = square t^2 + 2 half_linear t + constant and its root r, near = -constant / (half_linear + r) and far =
    constant / (r - half_linear): these denominators, over the length of the arm, fall to 0 as the meeting recedes, and
    are smooth where the stable form of a root changes.
    """
    arms = np.ascontiguousarray(arms)  # one origin for all rays rounds as one for each
    touching = _touching(arms, directions, axis, half_angle)
    exists = np.real(touching[0]) > 0
    root = _root_of(touching, exists, half_angle)
    middle = _half_linear(arms, directions, axis, half_angle)
    quadratic = quadratic_along(arms, directions, axis=axis, half_angle=half_angle)
    inside = np.where(np.real(quadratic.constant) > 0, 1.0, -1.0)
    far = _where(exists, inside, [r - m for r, m in zip(root, middle, strict=True)])
    near = _where(exists, -inside, [r + m for r, m in zip(root, middle, strict=True)])
    value, by_arm, by_direction, by_axis, by_half_angle = (
        np.stack(parts) for parts in zip(touching, far, near, strict=True)
    )
    return ConeFrontiers(value, by_arm, by_direction, by_axis, by_half_angle)


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


def _root_of(touching: tuple[Any, ...], exists: NDArray[np.bool_], half_angle: Any) -> list[Any]:
    """The root of the discriminant over the length of the arm: |cos(half_angle)| sqrt(touching), and its slopes."""
    root = np.sqrt(np.where(exists, touching[0], 1.0))
    cosine = np.cos(half_angle) * np.sign(np.real(np.cos(half_angle)))
    _, *slopes = touching
    by_arm, by_direction, by_axis, by_half_angle = (
        cosine * slope / (2 * root).reshape(-1, *(1,) * (slope.ndim - 1)) for slope in slopes
    )
    turn = -np.sin(half_angle) * np.sign(np.real(np.cos(half_angle)))
    return [cosine * root, by_arm, by_direction, by_axis, by_half_angle + turn * root]


def _half_linear(arms: NDArray[Any], directions: NDArray[Any], axis: NDArray[Any], half_angle: Any) -> list[Any]:
    """(axis . u) (axis . m) - cos^2 u . m over the length of the arm m, and its slopes."""
    square_cosine, along, reach = np.cos(half_angle) ** 2, directions @ axis, arms @ axis
    length, together = np.sqrt(dot(arms, arms)), dot(arms, directions)
    value = (along * reach - square_cosine * together) / length
    by_arm = along[:, None] * axis - square_cosine * directions - (value / length)[:, None] * arms
    by_direction = reach[:, None] * axis - square_cosine * arms
    by_axis = along[:, None] * arms + reach[:, None] * directions
    slopes = (slope / length[:, None] for slope in (by_arm, by_direction, by_axis))
    return [value, *slopes, np.sin(2 * half_angle) * together / length]


def _where(exists: NDArray[np.bool_], sign: NDArray[np.float64], row: list[Any]) -> tuple[Any, ...]:
    """`sign` times the row; infinitely far, with slopes 0, for rays that do not meet the double cone."""
    value, *slopes = row
    kept = (np.where(_beside(exists, slope), _beside(sign, slope) * slope, 0) for slope in slopes)
    return np.where(exists, sign * value, np.inf), *kept


def _beside(of_rays: NDArray[Any], slope: NDArray[Any]) -> NDArray[Any]:
    """(n, 1) of (n,), where the slope has three columns."""
    return of_rays.reshape(-1, *(1,) * (slope.ndim - 1))

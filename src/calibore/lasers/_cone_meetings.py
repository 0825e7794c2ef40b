"""Where rays meet a cone of light: both roots, in forms that hold where the ray runs along a generator."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.lasers._surface import GRAZING_SINE, MeetingFlag, Meetings


class Quadratic(NamedTuple):
    """square t^2 + 2 half_linear t + constant, positive inside the double cone, (n,) each."""

    square: NDArray[Any]
    half_linear: NDArray[Any]
    constant: NDArray[Any]
    discriminant: NDArray[Any]


def dot(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """(n,) of two arrays (n, 3)."""
    return np.einsum("ni,ni->n", a, b)


def quadratic_along(arms: NDArray[Any], directions: NDArray[Any], *, axis: NDArray[Any], half_angle: Any) -> Quadratic:
    """(axis . w)^2 - cos^2 w . w at w = arm + t direction; `arms` (n, 3) from the apex to the origins of the rays.

    The discriminant is that of Swanbom 2007, eq. 3-32, corrected, times (cos(half_angle) baseline)^2: with the normal
    of the plane through apex and ray, as here, it loses no digits where the ray touches the cone.
    """
    square_cosine, square_sine = np.cos(half_angle) ** 2, np.sin(half_angle) ** 2
    along, reach = directions @ axis, arms @ axis
    normal = np.cross(arms, directions)
    return Quadratic(
        along**2 - square_cosine * dot(directions, directions),
        along * reach - square_cosine * dot(arms, directions),
        reach**2 - square_cosine * dot(arms, arms),
        square_cosine * (square_sine * dot(normal, normal) - (normal @ axis) ** 2),
    )


def meetings_with_cone(
    arms: NDArray[Any], directions: NDArray[Any], *, axis: NDArray[Any], half_angle: Any
) -> Meetings:
    """Rows `NEAR` and `FAR`; NaN and `NONE` where the ray has no such meeting with the lit nappe."""
    arms = np.broadcast_to(arms, directions.shape)
    quadratic = quadratic_along(arms, directions, axis=axis, half_angle=half_angle)
    real = np.real(quadratic.discriminant) >= 0
    root = np.sqrt(np.where(real, quadratic.discriminant, 1))
    roots = _roots(quadratic, root)
    reach = arms @ axis + roots * (directions @ axis)
    lit = real & (np.real(np.cos(half_angle) * reach) > 0)
    distance = np.where(lit, roots, np.nan)
    # on the cone |w| = reach / cos, and grad F . u = root / (cos |w|)
    grazing = lit & (np.real(root) <= GRAZING_SINE * np.real(np.sin(half_angle)) * np.abs(np.real(reach)))
    flags = np.where(lit, np.array([[MeetingFlag.NEAR], [MeetingFlag.FAR]]), MeetingFlag.NONE).astype(np.uint8)
    flags |= np.where(grazing, MeetingFlag.GRAZING, MeetingFlag.NONE).astype(np.uint8)
    flags |= np.where(np.real(distance) <= 0, MeetingFlag.BEHIND, MeetingFlag.NONE).astype(np.uint8)
    return Meetings(distance, flags)


def _roots(quadratic: Quadratic, root: NDArray[Any]) -> NDArray[Any]:
    """(2, n): where the ray enters the double cone, and where it leaves it; of two equal forms the one that adds."""
    square, half_linear, constant, _ = quadratic
    rising = np.real(half_linear) > 0
    enters = np.where(rising, _quotient(-constant, half_linear + root), _quotient(root - half_linear, square))
    leaves = np.where(rising, _quotient(-half_linear - root, square), _quotient(constant, root - half_linear))
    return np.stack([enters, leaves])


def _quotient(numerator: NDArray[Any], denominator: NDArray[Any]) -> NDArray[Any]:
    nothing = denominator == 0
    return np.where(nothing, np.nan, numerator / np.where(nothing, 1, denominator))

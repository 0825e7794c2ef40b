"""Aim and half angle of the cone whose light falls on a round wall as a ring across the axis."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError


def ring_angles(baseline: Any, projection: Any, nominal_radius: Any) -> tuple[Any, Any, NDArray[Any]]:
    """`aim`, `half_angle` [rad] and their derivatives (2, 2) by (`baseline`, `projection`) [rad/m].

    Swanbom 2007, eq. 3-11 and 3-14, in a form that holds on both of their branches, and 3-48 to 3-51. A negative
    `projection` [m] is a ring behind the apex: a reversed cone.
    """
    if not 0 <= np.real(baseline) < np.real(nominal_radius) < np.inf:
        raise InputError(
            f"The baseline must be at least 0 and below the nominal radius of {nominal_radius} m, got {baseline} m; "
            "the laser stands inside the pipe."
        )
    if not 0 < abs(np.real(projection)) < np.inf:
        raise InputError(
            f"The projection must be a length other than 0, got {projection} m; "
            "state where the ring falls, ahead (> 0) or behind (< 0)."
        )
    far, near = nominal_radius + baseline, nominal_radius - baseline
    far_angle, near_angle = (np.pi / 2 - np.arctan(projection / height) for height in (far, near))
    far_square, near_square = far**2 + projection**2, near**2 + projection**2
    far_slopes = np.array([projection / far_square, -far / far_square])
    near_slopes = np.array([-projection / near_square, -near / near_square])
    jacobian = np.array([far_slopes - near_slopes, far_slopes + near_slopes]) / 2
    return (far_angle - near_angle) / 2, (far_angle + near_angle) / 2, jacobian

"""What may be asked of a rig: checked before it is computed, in one sentence each."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.lasers import Cone
from calibore.rigs._rig import Rig
from calibore.units import LARGEST

FAR_OUTSIDE = 1e9
"""px; as far from any picture as infinity, and still a number that can be squared."""


def pixels_of(u: ArrayLike, v: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    """Pixels (n,) and (n,), or one of either for all; those at infinity are `FAR_OUTSIDE`."""
    u, v = (np.atleast_1d(np.asarray(values) * 1.0) for values in (u, v))
    if u.ndim > 1 or v.ndim > 1 or (u.size != v.size and 1 not in (u.size, v.size)):
        raise InputError(f"Pixels need as many u as v, in one row, got shapes {u.shape} and {v.shape}.")
    return _bounded(u), _bounded(v)


def _bounded(values: NDArray[Any]) -> NDArray[Any]:
    return values if np.iscomplexobj(values) else np.clip(values, -FAR_OUTSIDE, FAR_OUTSIDE)


def check_laser(rig: Rig, laser: int) -> None:
    """Raise InputError where the rig has no such laser."""
    if not 0 <= laser < len(rig.lasers):
        raise InputError(f"The rig has {len(rig.lasers)} lasers, numbered from 0, and none of number {laser}.")


def check_choice(rig: Rig, laser: int, prior_radius: ArrayLike | None, branch: ArrayLike | None) -> None:
    """Raise InputError where a meeting of that number, or a wall of that radius, cannot be; NaN is a missing radius."""
    check_laser(rig, laser)
    if branch is not None:
        most, numbers = (1 if isinstance(rig.lasers[laser].surface, Cone) else 0), np.asarray(branch)
        if not np.isin(numbers, np.arange(most + 1)).all():
            raise InputError(f"Meetings of a ray with this surface have the numbers 0 to {most}; branch has others.")
    elif prior_radius is not None:
        radius = np.asarray(prior_radius, dtype=float)
        if ((radius < 1 / LARGEST["length"]) | (radius > LARGEST["length"])).any():
            raise InputError("prior_radius must be positive and that of a pipe; give roughly the wall's radius [m].")


def check_noise(u_pixel: NDArray[np.float64], probability: float | None = None) -> None:
    """Raise InputError where a standard uncertainty or a probability cannot be; NaN is a missing uncertainty."""
    if ((u_pixel < 0) | (u_pixel > FAR_OUTSIDE)).any():
        raise InputError("u_pixel must be a length in the image; give the standard uncertainty [px] of each pixel.")
    if probability is not None and not 0 < probability < 1:
        raise InputError(f"A probability must lie between 0 and 1, got {probability:g}; give 0.95, say, or None.")

"""Where a round wall about the rig axis would appear in the image."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.rigs._rig import Rig

AHEAD = (0.0, 0.0, 1.0)


def project_ring(
    rig: Rig, radius: ArrayLike, n: int, *, laser: int = 0
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """`n` clock positions [rad] and the pixels u, v (n,) of the lit line on a wall of `radius` [m], a number or (n,).

    The wall meets the laser surface along lines parallel to the rig axis. NaN where the lens does not see the line.
    """
    radius = np.broadcast_to(np.asarray(radius, dtype=float), n)
    if not (np.isfinite(radius).all() and (radius > 0).all()):
        raise InputError(f"The ring's radius must be positive, got {radius.min()} m.")
    clock = np.arange(n) * (2 * np.pi / n)
    feet = np.stack([*xy_of(clock, radius), np.zeros(n)], axis=1)
    meetings = rig.lasers[laser].surface.meet(feet, np.broadcast_to(AHEAD, feet.shape))
    feet[:, 2] = np.where(meetings.admissible[0], meetings.distance[0], np.nan)
    return clock, *rig.camera.project(feet)

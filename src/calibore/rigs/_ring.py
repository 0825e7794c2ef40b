"""Where a round wall about the rig axis would appear in the image."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.lasers import Beam
from calibore.rigs._mount import SideFacing
from calibore.rigs._rig import Rig

AHEAD = (0.0, 0.0, 1.0)


def project_ring(
    rig: Rig, radius: ArrayLike, n: int, *, laser: int = 0
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """`n` clock positions [rad] and the pixels u, v (n,) of the lit line on a wall of `radius` [m], a number or (n,).

    The wall meets the laser surface along lines parallel to the rig axis; of several meetings the first that is lit
    counts. NaN where the lens does not see the line. A side-facing sheet meets a wall in no ring.
    """
    surface = rig.lasers[laser].surface
    if isinstance(rig.mount, SideFacing) or isinstance(surface, Beam):
        raise InputError(f"The light of a {rig.configuration} rig draws no ring on the wall; use `triangulate`.")
    radius = np.broadcast_to(np.asarray(radius, dtype=float), n)
    if not (np.isfinite(radius).all() and (radius > 0).all()):
        raise InputError(f"The ring's radius must be positive, got {radius.min()} m.")
    clock = np.arange(n) * (2 * np.pi / n)
    feet = np.stack([*xy_of(clock, radius), np.zeros(n)], axis=1)
    meetings = surface.meet(feet, np.broadcast_to(AHEAD, feet.shape))
    lit = meetings.admissible
    first = np.argmax(lit, axis=0), np.arange(n)
    feet[:, 2] = np.where(lit[first], np.where(lit, meetings.distance, np.nan)[first], np.nan)
    return clock, *rig.project(feet)

"""Lit points of a round wall about the rig axis."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.lasers import Beam
from calibore.rigs._mount import SideFacing
from calibore.rigs._rig import Rig

AHEAD = (0.0, 0.0, 1.0)


def lit_points(
    rig: Rig, clock: ArrayLike, radius: ArrayLike, *, laser: int = 0, axial: ArrayLike = 0.0
) -> NDArray[Any]:
    """Points (n, 3) of the rig frame that `laser` lights on walls of `radius` [m] at `clock` [rad], (n,) each; NaN
    where no light falls.

    Forward-looking rigs: where the line along the wall meets the surface, the first that is lit. A side-facing head is
    turned to the clock, so that in its frame the point lies at y = radius, at `axial` [m] along the sheet. A beam
    lights one clock only, its own; `clock` then does not count.
    """
    clock, radius, axial = np.broadcast_arrays(*(np.asarray(a, dtype=float).ravel() for a in (clock, radius, axial)))
    if (radius <= 0).any():
        raise InputError(f"The radius of a wall must be positive, got {radius.min()} m.")
    surface = rig.lasers[laser].surface
    if isinstance(surface, Beam):
        return _on_beam(surface, radius)
    if isinstance(rig.mount, SideFacing):
        feet, way = np.stack([np.zeros_like(radius), radius, axial], axis=1), (1.0, 0.0, 0.0)
    else:
        feet, way = np.stack([*xy_of(clock, radius), np.zeros_like(radius)], axis=1), AHEAD
    meetings = surface.meet(feet, np.broadcast_to(way, feet.shape))
    lit = _lit(meetings.distance, meetings.flags, either_way=isinstance(rig.mount, SideFacing))
    first = np.argmax(lit, axis=0), np.arange(len(feet))
    distance = np.where(lit[first], np.where(lit, meetings.distance, np.nan)[first], np.nan)
    return feet + distance[:, None] * np.asarray(way)


def _lit(distance: NDArray[Any], flags: NDArray[np.uint8], *, either_way: bool) -> NDArray[np.bool_]:
    """Where light falls on the line along the wall; ahead of the pupil, or on either side of the head's range."""
    there = (flags != 0) & np.isfinite(distance)
    return there if either_way else there & (distance > 0)


def _on_beam(beam: Beam, radius: NDArray[Any]) -> NDArray[Any]:
    """Where the beam leaves the wall: the farther of its two crossings of the cylinder."""
    source, way = beam.source, beam.direction
    a, b = way[:2] @ way[:2], way[:2] @ source[:2]
    discriminant = b**2 - a * (source[:2] @ source[:2] - radius**2)
    found = (discriminant >= 0) & (a > 0)
    distance = np.where(found, (np.sqrt(np.where(found, discriminant, 0.0)) - b) / (a or 1.0), np.nan)
    distance = np.where(distance > 0, distance, np.nan)
    return source + distance[:, None] * way

"""What a picture of the light on a gauge or a flat, not taken yet, would tell of a rig."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._on_the_wall import wall_pixels
from calibore.calibration._planning._shots import Shot
from calibore.calibration._planning._targets import PlannedFlats, PlannedGauges
from calibore.calibration._rig._references import AHEAD, OUTWARDS, FlatTarget, Reference, RingGauge
from calibore.geometry import xy_of
from calibore.optics import Camera
from calibore.rigs import Rig, SideFacing, triangulate
from calibore.status import Status

Array = NDArray[Any]
FEWEST_MARKS = 8
EDGE = 5.0
"""px from the image's border within which no mark is found."""
STEP = 1e-4
"""rad or fraction: of differences along a line, whose direction needs no more digits."""


@dataclass(frozen=True, eq=False)
class Picture:
    """`rows` (n, p) by `rig.parameter_names`, `beside` (n, q) by poses and settings, of standard uncertainty
    `beside_u` (q,) before (infinite: unknown), `shared` (n, s) by errors of the target's own making, `shared_u`, named
    `keys`: pictures of one target have them in common. All in units of the noise.
    """

    rows: Array
    beside: Array
    beside_u: Array
    shared: Array
    shared_u: Array
    keys: tuple[str, ...]


def picture_of_light(rig: Rig, target: PlannedGauges | PlannedFlats, shot: Shot) -> Picture | None:
    """Of the lines of all lasers; None where the image shows too little of them.

    A mark's gap to the surface over its slope along the mark's direction is its error in pixels, as in calibrations.
    The error of a gauge comes with every picture of it, that of a reading is new each time.
    """
    reference = _reference(rig, target, shot)
    parts = [_rows(rig, target, shot, reference, laser) for laser in range(len(rig.lasers))]
    parts = [part for part in parts if len(part[0]) >= FEWEST_MARKS]
    if not parts:
        return None
    rows, beside, error = (np.concatenate(part) / target.noise for part in zip(*parts, strict=True))
    setting, none = reference.nuisance_u, np.zeros((len(rows), 0))
    if isinstance(target, PlannedGauges):
        return Picture(rows, beside, setting, error, np.array([target.u]), (shot.said(),))
    return Picture(rows, np.hstack([beside, error]), np.append(setting, target.u), none, np.zeros(0), ())


def across_line(along: Array) -> Array:
    """(n, 2) unit vectors across a line that runs `along` (n, 2) in the image."""
    return np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)


def in_picture(camera: Camera, u: Array, v: Array) -> NDArray[np.bool_]:
    """Whether marks at `u`, `v` (n,) [px] can be found."""
    return (u >= EDGE) & (u <= camera.width - 1 - EDGE) & (v >= EDGE) & (v <= camera.height - 1 - EDGE)


def _rows(
    rig: Rig, target: PlannedGauges | PlannedFlats, shot: Shot, reference: Reference, laser: int
) -> tuple[Array, Array, Array]:
    """Errors of marks [px] by the rig (n, p), by the setting of the reference (n, q) and by its error (n, 1)."""
    ahead, behind = (np.stack(_lit(rig, target, shot, laser, step)[:2], axis=1) for step in (STEP, -STEP))
    u, v, radius = _lit(rig, target, shot, laser, 0.0)
    direction = across_line(ahead - behind)
    seen = in_picture(rig.camera, u, v) & np.isfinite(direction[:, 0])
    found = triangulate(rig, u[seen], v[seen], laser=laser, prior_radius=radius[seen])
    gap = reference.gap(found.points, np.zeros(reference.nuisance_u.size))
    slope = np.einsum("ni,nij,nj->n", gap.by_point, found.d_pixel, direction[seen])
    lit = (found.status == Status.OK) & (slope != 0)
    by_rig = np.einsum("ni,nip->np", gap.by_point, found.d_parameters)
    parts = by_rig, gap.by_nuisance, -np.ones((slope.size, 1))
    by_rig, by_setting, by_error = (part[lit] / slope[lit, None] for part in parts)
    return by_rig, by_setting, by_error


def _reference(rig: Rig, target: PlannedGauges | PlannedFlats, shot: Shot) -> Reference:
    if isinstance(target, PlannedGauges):
        return RingGauge(shot.diameter or 0.0, u=target.u, u_tilt=target.u_tilt)
    direction = OUTWARDS if isinstance(rig.mount, SideFacing) else AHEAD
    return FlatTarget(shot.distance or 0.0, direction, target.u, (target.u_tilt, target.u_tilt))


def _lit(
    rig: Rig, target: PlannedGauges | PlannedFlats, shot: Shot, laser: int, step: float
) -> tuple[Array, Array, Array]:
    """Pixels u, v (n,) of the marks, a `step` on along the line, and their distance [m] from the rig's axis."""
    clock = np.arange(target.marks) * (2 * np.pi / target.marks) + step
    if shot.diameter is not None:
        radius = np.full(clock.size, shot.diameter / 2)
        return *wall_pixels(rig, clock, radius, laser=laser), radius
    distance = shot.distance or 0.0
    if isinstance(rig.mount, SideFacing):
        low, high = _seen_along(rig, distance, laser)
        along, radius = np.linspace(low, high, target.marks) + step * distance, np.full(clock.size, distance)
        return *wall_pixels(rig, clock, radius, laser=laser, axial=along), radius
    ways = np.stack([*xy_of(clock, 1.0), np.zeros(clock.size)], axis=1)
    feet = np.tile([0.0, 0.0, distance], (clock.size, 1))
    meetings = rig.lasers[laser].surface.meet(feet, ways)
    there = (meetings.flags != 0) & np.isfinite(meetings.distance) & (meetings.distance > 0)
    first = np.argmax(there, axis=0), np.arange(clock.size)
    radius = np.where(there, meetings.distance, np.nan)[first]
    return *rig.project(feet + radius[:, None] * ways), radius


def _seen_along(rig: Rig, distance: float, laser: int) -> tuple[float, float]:
    """From where to where along the sheet [m] the image shows a flat at `distance`; NaN where it shows none."""
    along = np.linspace(-2.0, 2.0, 801) * distance
    pixels = wall_pixels(rig, 0 * along, np.full(along.size, distance), laser=laser, axial=along)
    seen = along[in_picture(rig.camera, *pixels)]
    return (float(seen.min()), float(seen.max())) if seen.size else (np.nan, np.nan)

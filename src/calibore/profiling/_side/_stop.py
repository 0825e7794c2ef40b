"""One stop of carriage and head: its pictures, the lines in them, the strip of wall they show."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.geometry import Pose
from calibore.images import Pixels, StationImages
from calibore.profiling._line_ring import rays_of
from calibore.profiling._placement import Placement
from calibore.profiling._reading import line_down
from calibore.profiling._search import check_size, exposure
from calibore.profiling._side._column import Column, Strip, column_of, one_of_takes, rows_of
from calibore.profiling._side._job import SideJob
from calibore.profiling._station import NOT_LIT, RefusedImage, StationRefusedError, refusal_of, wall_points
from calibore.profiling._take import place_on_wall
from calibore.scans import RingPoints
from calibore.status import Status, has_value
from calibore.stripe import Stripe, detect_line

Array = NDArray[np.float64]
LEAST_LINE = 0.05
"""A line must be seen in at least this fraction of the rows."""


@dataclass(frozen=True)
class Stop:
    """The `images` taken where the carriage stood at `placement`, the head at `clock` [rad], the roll of the carriage
    included; `position` of the clock grid.
    """

    images: StationImages
    placement: Placement
    clock: float
    position: int

    @property
    def pipe_from_head(self) -> Pose:
        """The y of the head's frame points radially outwards at its clock."""
        return self.placement.pipe_from_rig @ Pose.from_roll_pitch_yaw(self.clock - self.placement.roll + np.pi)


@dataclass(frozen=True)
class StopLines:
    """The line of each take that has one; `refused` images, and takes in which the laser is not lit."""

    stop: Stop
    lines: tuple[tuple[int, Stripe], ...]
    refused: tuple[RefusedImage, ...]
    unlit: tuple[int, ...]


@dataclass(frozen=True)
class StopResult:
    """What one stop gave: its `column` of the grid and its `points`; the other names as in `StationResult`."""

    stop: Stop
    column: Column
    points: RingPoints
    images: int
    refused: tuple[RefusedImage, ...]
    unlit: tuple[int, ...]
    scale: float
    take_correlation: float
    stripe: Stripe
    first_image: Callable[[], Pixels]


def find_stop_lines(stop: Stop, job: SideJob) -> StopLines:
    """Read the images of a stop and find their lines; compiled code that gains from threads."""
    images = stop.images
    lit = [take for take in images.takes if job.rig.lasers[0].is_lit(take)]
    unlit = tuple(take for take in images.takes if take not in lit)
    refused = [] if lit else [RefusedImage(images.name(take), NOT_LIT) for take in unlit]
    lines = []
    for take in lit:
        try:
            lines.append((take, _line_in(images, take, job)))
        except ImageError as error:
            refused.append(refusal_of(images.name(take), error))
    return StopLines(stop, tuple(lines), tuple(refused), unlit)


def _line_in(images: StationImages, take: int, job: SideJob) -> Stripe:
    stripe = line_down(images, take, job.rig, channel=job.channel, estimator=job.estimator)
    if stripe is not None and np.count_nonzero(stripe.found) >= LEAST_LINE * stripe.u.size:
        return stripe
    return _find_line(images.read(take), job)


def _find_line(image: Pixels, job: SideJob) -> Stripe:
    """The line down one image; raises ImageError where there is none."""
    check_size(image, job.rig)
    stripe = detect_line(image, down=True, channel=job.channel, estimator=job.estimator)
    found, rows = int(np.count_nonzero(stripe.found)), image.shape[0]
    if found < LEAST_LINE * rows:
        raise ImageError(
            f"there is no laser line down the image: one was found in {found} of {rows} rows "
            f"({exposure(image, job.channel)}); check exposure and laser.channel"
        )
    return stripe


def evaluate_stop(lines: StopLines, job: SideJob) -> StopResult:
    """The strip of wall that follows from the lines of a stop; raises StationRefusedError where none is of use."""
    stop, refused = lines.stop, list(lines.refused)
    strips: list[tuple[int, Strip]] = []
    for take, stripe in lines.lines:
        try:
            strips.append((take, strip_of(stripe, stop, job)))
        except ImageError as error:
            refused.append(refusal_of(stop.images.name(take), error))
    if not strips:
        raise StationRefusedError(refused)
    takes, rows = [strip.take for _, strip in strips], rows_of([strip for _, strip in strips], job.axial_step)
    columns = [
        column_of(strip, job.covariance, step=job.axial_step, rows=rows, stripe=job.rig.stripe) for _, strip in strips
    ]
    column, shared = one_of_takes(columns, [take.stripe for take in takes])
    numbers = [take for take, _ in strips]
    rays = [rays_of(take, job.covariance) for take in takes]
    points = wall_points(rays, numbers, stop.pipe_from_head, stop.clock + np.pi)
    scale = float(np.mean([take.stripe.scale for take in takes]))
    read = partial(stop.images.read, numbers[0])
    return StopResult(
        stop, column, points, len(takes), tuple(refused), lines.unlit, scale, shared, takes[0].stripe, read
    )


def strip_of(stripe: Stripe, stop: Stop, job: SideJob) -> Strip:
    """The line as points of the wall; raises ImageError where none lies where the wall is looked for."""
    take = place_on_wall(stripe, job.rig)
    low, high = job.search
    beyond = has_value(take.status) & ~((take.points.radius >= low) & (take.points.radius <= high))
    status = np.where(beyond, Status.OFF_RING, take.status).astype(np.uint8)
    seen = has_value(status)
    if np.count_nonzero(seen) < 2:
        raise ImageError(
            f"its line does not lie on a wall of radius {low:.4g} to {high:.4g} m; check rig file, pipe.nominal_radius "
            "and [search]"
        )
    clock = np.where(np.isfinite(take.points.clock), take.points.clock, np.pi)
    offset = job.clocks.offset(clock - np.pi + stop.clock, stop.position)
    axial = _every_axial(np.where(seen, take.points.axial, np.nan)) + stop.placement.axial
    return Strip(replace(take, clock=clock, status=status), axial, offset)


def _every_axial(axial: Array) -> Array:
    """`axial` (n,) with its gaps interpolated along the rows, and continued to both ends."""
    row, found = np.arange(axial.size), np.flatnonzero(np.isfinite(axial))
    first, last = found[0], found[-1]
    slope = (axial[last] - axial[first]) / (last - first)
    inside = np.interp(row, found, axial[found])
    return inside + slope * (np.minimum(row - first, 0) + np.maximum(row - last, 0))

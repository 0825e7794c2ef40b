"""From readings to rings: radii with status, independent uncertainty and the modes that all of them share."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.metrics import RingQuantities, RingShape, ring_quantities
from calibore.profiling._station import ring_row
from calibore.profiling._tactile._faults import faults, scatter
from calibore.profiling._tactile._readings import Readings
from calibore.profiling._tactile._tip import Contact, touch
from calibore.rigs import Probe
from calibore.scans import RingPoints, RingProfile
from calibore.status import Status, has_value

Array = NDArray[np.float64]
BEYOND = 0.02
"""Of the calibrated stroke: further outside, a reading is extrapolated."""
DEFAULT_DRIFT = 0.001 * 0.0254 / np.sqrt(3)
"""m; limits of 0.001 in, the mechanical repeatability that Bimba states of its position feedback cylinders: an
assumption, for repeatability is not drift, and nothing in a scan tells drift from a taper of the pipe."""


@dataclass(frozen=True, eq=False)
class Wall:
    """What n rings of m stops tell: `contact`, `status` (n, m), `modes` (k, n, m) [m]; `usual` [m]: scatter of a
    reading about a smooth wall.
    """

    contact: Contact
    status: NDArray[np.uint8]
    modes: Array
    usual: float


@dataclass(frozen=True)
class RingResult:
    """What one ring gave."""

    profile: RingProfile
    points: RingPoints
    row: dict[str, float | int | str]
    quantities: RingQuantities


def measure_wall(readings: Readings, probe: Probe, *, drift: float) -> Wall:
    """The wall from `readings`; `drift` [m]: standard uncertainty of what the probe shifts by during the scan."""
    ratio, grid = readings.ratio, readings.grid
    radius = probe.radius(ratio)
    found = faults(radius, grid, noise=probe.noise)
    usual = scatter(np.where(found == Status.OK, radius, np.nan), grid, noise=probe.noise)
    good = (found == Status.OK) & np.isfinite(radius)
    tellable = np.where(found == Status.STUCK, np.nan, radius)
    contact = touch(tellable, grid, good=good, noise=probe.noise, usual=usual)
    status = _status(found, ratio, contact, probe)
    modes = [*np.moveaxis(probe.common_modes(ratio), -1, 0), *_drift(ratio.shape, drift)]
    return Wall(contact, status, np.stack(modes) + 0 * contact.radius, usual)


def _status(found: NDArray[np.uint8], ratio: Array, contact: Contact, probe: Probe) -> NDArray[np.uint8]:
    low, high = probe.stroke
    margin = BEYOND * (high - low)
    status = np.where((ratio < low - margin) | (ratio > high + margin), Status.EXTRAPOLATED, Status.OK)
    status = np.where(found != Status.OK, found, status)
    status = np.where(np.isnan(contact.radius) & has_value(status), Status.OFF_TIP, status)
    return np.where(np.isnan(ratio), Status.NO_READING, status).astype(np.uint8)


def _drift(shape: tuple[int, ...], drift: float) -> Iterator[Array]:
    """Two modes (n, m) of `drift` [m] that every ring has, alike in neighbouring rings, unrelated in first and last."""
    time = np.pi / 2 * np.arange(shape[0])[:, None] / max(shape[0] - 1, 1)
    for wave in (np.cos(time), np.sin(time)):
        yield np.broadcast_to(drift * wave, shape)


def rings_of(wall: Wall, readings: Readings, *, nominal_radius: float) -> Iterator[RingResult]:
    """Every ring in the order of the table."""
    clock, contact, none = readings.grid.clock, wall.contact, np.zeros(0)
    for index, (station, place) in enumerate(zip(readings.stations, readings.placements, strict=True)):
        radius, u, modes = contact.radius[index], contact.u[index], wall.modes[:, index]
        shape = RingShape(clock, radius, u, modes, none)
        quantities = ring_quantities(shape, nominal_radius=nominal_radius, roll=place.roll)
        profile = RingProfile(
            station=station,
            axial=place.axial,
            clock=clock,
            radius=radius,
            axial_position=place.axial + 0 * radius,
            u_independent=u,
            common_mode=modes,
            status=wall.status[index],
            centre_x=quantities.centre_x.value,
            centre_y=quantities.centre_y.value,
            u_centre_x=quantities.centre_x.u,
            u_centre_y=quantities.centre_y.u,
            time_s=place.time,
            roll=place.roll,
        )
        yield RingResult(profile, _points(wall, readings, index), ring_row(quantities, takes=1), quantities)


def _points(wall: Wall, readings: Readings, index: int) -> RingPoints:
    """Where the ball touched, in the pipe frame; readings without a value with the status that says why."""
    contact, place, clock = wall.contact, readings.placements[index], readings.grid.clock
    radius, angle = contact.touch_radius[index], contact.touch_clock[index]
    along = contact.touch_axial[index] - place.axial
    wall_points = place.pipe_from_rig.apply(np.stack([radius * np.sin(angle), -radius * np.cos(angle), along], axis=-1))
    where = np.where(np.isfinite(angle), angle, clock) + place.roll
    nothing = np.full(clock.size, np.nan)
    return RingPoints(
        x=wall_points[:, 0],
        y=wall_points[:, 1],
        z=wall_points[:, 2],
        radius=radius,
        clock=np.mod(where, 2 * np.pi),
        axial=wall_points[:, 2],
        u_radius=np.sqrt(contact.u[index] ** 2 + np.sum(wall.modes[:, index] ** 2, axis=0)),
        u=nothing,
        v=nothing,
        take=np.zeros(clock.size, dtype=np.int64),
        status=wall.status[index],
    )

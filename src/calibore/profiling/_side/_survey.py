"""A side-facing scan measured: stop by stop to columns, column by column to the grid, row by row to the result."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from itertools import groupby
from typing import Any

import numpy as np

from calibore.crews import Cluster, Workers, in_order
from calibore.errors import InputError
from calibore.images import ImageSource
from calibore.metrics import RingQuantities, RingShape, ring_quantities
from calibore.profiling._grid import Ring
from calibore.profiling._measured import Measured, Measurement, Progress
from calibore.profiling._placement import Placement, Placer
from calibore.profiling._side._gaps import gaps_of
from calibore.profiling._side._job import SideJob, prepare_side
from calibore.profiling._side._merge import merged
from calibore.profiling._side._stop import Stop, StopLines, StopResult, evaluate_stop, find_stop_lines
from calibore.profiling._side._wall import Wall
from calibore.profiling._station import StationRefusedError, ring_profile, ring_row
from calibore.profiling._summary import Tally, summarise
from calibore.scans import ResultWriter, RingPoints, RingProfile, ScanSpec

_NONE: list[Any] = [np.zeros(0, dtype=np.uint8)]
NO_POINTS = RingPoints(*_NONE * len(fields(RingPoints)))
"""The points were written stop by stop."""
SPARSE = 0.999
"""Share of the clock positions below which a summary says how many were photographed."""


@dataclass
class SideTally(Tally):
    """What was measured and what could not be, of a scan whose stops have two numbers."""

    missing: list[str] = field(default_factory=list)

    def gaps(self) -> list[str]:
        return self.missing


def side_measurement(spec: ScanSpec, *, estimator: str, workers: Workers, progress: Progress | None) -> Measurement:
    """The measurement of a side-facing scan, everything checked that can be before its first image is read."""
    job, source, place = prepare_side(spec, estimator=estimator)
    tally = SideTally()
    stops = _stops(source, place, job, tally)
    tally.missing = gaps_of(stops, expected=sorted(place.expected)) if stops else []
    angles = {stop.images.angular for stop in stops}
    if len(angles) == 1:
        raise InputError(
            f"{spec.folder}: all images are of angular stop {min(angles)}: that is one strip of the wall, no pipe. Add "
            "the images of the other stops, or correct images.pattern."
        )

    def measure(writer: ResultWriter) -> Measured:
        wall, takes, example = Wall(job.clocks, job.axial_step), 1, None
        results = measure_stops(stops, job, workers=workers, tally=tally, progress=progress)
        for position, group in groupby(results, key=lambda result: result.stop.position):
            columns = []
            for result in group:
                writer.add_points(result.points, result.stop.images.station)
                columns.append(result.column)
                takes = max(takes, result.images)
                example = example or (result.first_image(), result.stripe)
            wall.columns[position] = merged(columns)
        if not wall.columns:
            raise InputError(tally.nothing_left(spec.folder))
        _write_rows(wall, job, writer, tally, takes=takes, workers=workers)
        return Measured(_summary(spec, job, tally, wall, stops), job.rig, example)

    return measure


def _stops(source: ImageSource, place: Placer, job: SideJob, tally: Tally) -> list[Stop]:
    """All stops whose place is known, clock position by clock position."""
    stops, unplaced = [], []
    for images in source.stations():
        placement = place(images)
        if placement is None:
            unplaced.append((images.station, len(images.takes)))
            continue
        clock = float(job.angular.clock(images.angular)) + placement.roll
        stops.append(Stop(images, placement, clock, job.clocks.nearest(clock)))
    by_station = {station: sum(count for one, count in unplaced if one == station) for station, _ in unplaced}
    tally.leave_out(list(by_station.items()), source.refusals, expected=place.expected)
    return sorted(stops, key=lambda stop: (stop.position, stop.images.angular, stop.images.station))


def measure_stops(
    stops: Sequence[Stop], job: SideJob, *, workers: Workers, tally: Tally, progress: Progress | None = None
) -> Iterator[StopResult]:
    """Every usable stop in order; what could not be used is counted and named in `tally`."""
    remote = isinstance(workers, Cluster)

    def work(stop: Stop) -> StopLines | StopResult | StationRefusedError:
        lines = find_stop_lines(stop, job)
        return _evaluated(lines, job) if remote else lines

    for done, found in enumerate(in_order(stops, work, workers=workers), start=1):
        result = _evaluated(found, job) if isinstance(found, StopLines) else found
        if isinstance(result, StationRefusedError):
            tally.refuse(result.images)
        else:
            tally.add_images(result)
            yield result
        if progress:
            progress(done, len(stops))


def _evaluated(lines: StopLines, job: SideJob) -> StopResult | StationRefusedError:
    try:
        return evaluate_stop(lines, job)
    except StationRefusedError as refused:
        return refused


def _write_rows(wall: Wall, job: SideJob, writer: ResultWriter, tally: Tally, *, takes: int, workers: Workers) -> None:
    def work(item: tuple[int, tuple[float, Ring]]) -> tuple[RingProfile, RingQuantities]:
        number, (axial, ring) = item
        shape = RingShape(ring.clock, ring.radius, ring.u, ring.modes, ring.correlation)
        quantities = ring_quantities(shape, nominal_radius=job.nominal_radius)
        return ring_profile(number, Placement(axial), ring, quantities), quantities

    here = 1 if isinstance(workers, Cluster) else workers
    for profile, quantities in in_order(enumerate(wall.rows()), work, workers=here):
        row = ring_row(quantities, takes=takes)
        tally.add_ring(profile, quantities, row, expected=wall.visited)
        writer.add(profile, NO_POINTS, row)


def _summary(spec: ScanSpec, job: SideJob, tally: Tally, wall: Wall, stops: Sequence[Stop]) -> dict[str, Any]:
    summary = summarise(spec, job, tally)
    summary["counts"]["stops"] = len(stops)
    summary["grid"] = {
        "axial_step_m": wall.step,
        "clock_step_rad": wall.clocks.step,
        "photographed": wall.visited,
        "axial_noise_correlation": wall.axial_correlation,
    }
    if wall.visited < SPARSE:
        summary["warnings"].append(
            f"{len(wall.columns)} of {wall.clocks.count} clock positions were photographed; what ring quantities say "
            "of the wall between them is bridged."
        )
    return summary

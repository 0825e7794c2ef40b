"""The main job: a scan folder in, a measured pipe out."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from calibore.crews import Workers, in_order
from calibore.errors import InputError
from calibore.images import ImageFolder, ImageSource, StationImages, read_ahead
from calibore.lasers import Beam
from calibore.profiling._job import Job
from calibore.profiling._lasers import check_told_apart
from calibore.profiling._measured import Example, Measured, Measurement, Progress
from calibore.profiling._placement import Placement, Placer, open_source
from calibore.profiling._side import side_measurement
from calibore.profiling._spacetime import Window, spacetime_reach, swept, windows
from calibore.profiling._station import (
    StationRefusedError,
    StationResult,
    evaluate_station,
    find_lines,
)
from calibore.profiling._summary import Tally, summarise
from calibore.profiling._tactile import tactile_measurement
from calibore.rigs import FORWARD, Probe, Rig, read_rig
from calibore.scans import ResultWriter, ScanSpec, read_scan
from calibore.stripe import estimator_named

_Item = tuple[StationImages, Placement] | tuple[StationImages, Placement, Window]


class Finisher(Protocol):
    """Called once everything is measured, to put pictures and a report beside the arrays."""

    def __call__(self, sealed: "Sealed", /) -> None: ...


@dataclass(frozen=True)
class Sealed:
    """A complete measurement that has not got its name yet: `folder` may be read, and files may be added to it.

    `example`: one image with the line found in it.
    """

    folder: Path
    spec: ScanSpec
    rig: Rig | None
    summary: dict[str, Any]
    example: Example | None


@dataclass
class _Reading:
    """Draws stations from the source, leaving out those that the motion table does not know."""

    source: ImageSource
    place: Placer
    tally: Tally
    ahead: bool = False
    """Whether the system is told of files before they are wanted: not where other machines read them."""
    unplaced: list[tuple[int, int]] = field(default_factory=list)
    """Station and number of its images."""

    def __iter__(self) -> Iterator[tuple[StationImages, Placement]]:
        stations = self.source.stations()
        for images in read_ahead(stations) if self.ahead else stations:
            self.tally.see(images)
            placement = self.place(images)
            if placement is None:
                self.unplaced.append((images.station, len(images.takes)))
            else:
                yield images, placement


def prepare(spec: ScanSpec, *, estimator: str) -> tuple[Job, ImageSource, Placer]:
    """Everything that can be wrong with a scan before its first image is read, found out."""
    rig = forward_rig(spec, estimator=estimator)
    source, channel, place = open_source(spec, rig)
    return forward_job(spec, rig, channel=channel, estimator=estimator), source, place


def forward_rig(spec: ScanSpec, *, estimator: str) -> Rig:
    """The rig of a scan of laser rings ahead of the camera; raises InputError where it is none."""
    estimator_named(estimator)
    if spec.kind != "forward-looking":
        raise InputError(
            f"{spec.folder} is a {spec.kind} scan, which has no rings in its images; profile_scan takes every kind."
        )
    if spec.rig_path is None:
        raise InputError(f'{spec.folder / "scan.toml"} names no rig; add rig = "rig.toml".')
    rig = read_rig(spec.rig_path)
    if rig.mount != FORWARD or any(isinstance(laser.surface, Beam) for laser in rig.lasers):
        raise InputError(
            f"{spec.rig_path} describes a {rig.configuration} rig, but {spec.folder / 'scan.toml'} a scan of laser "
            "rings ahead of the camera; name the rig file that belongs to it (a side-facing head needs {angular} in "
            "images.pattern, and motion.angular)."
        )
    return rig


def forward_job(spec: ScanSpec, rig: Rig, *, channel: str, estimator: str) -> Job:
    """What all stations of the scan share; `channel` for lasers of which the rig file names none."""
    try:
        job = Job.of(
            rig,
            spec.nominal_radius,
            channel=channel,
            estimator=estimator,
            inner=spec.search_inner,
            outer=spec.search_outer,
        )
    except InputError as error:
        raise InputError(f"{spec.folder / 'scan.toml'} and its rig file do not fit together: {error}") from error
    try:
        check_told_apart(rig, job.looks)
    except InputError as error:
        raise InputError(f"{spec.rig_path}: {error}") from error
    return job


def measure_scan(
    job: Job, source: ImageSource, place: Placer, *, workers: Workers, tally: Tally, sweep: float | None = None
) -> Iterator[StationResult]:
    """Every usable station in order; what could not be used is counted and named in `tally`.

    Nearly all of a station is compiled code that does not hold Python's lock, so workers do all of it side by side.
    `sweep` [m]: how far along the pipe the light is followed over a place (`spacetime_reach`); None: no further.
    """
    reading = _Reading(source, place, tally, isinstance(source, ImageFolder) and isinstance(workers, int))
    stops = reading if sweep is None else windows(reading, sweep)
    for result in in_order(stops, partial(_measured, job), workers=workers):
        if isinstance(result, StationRefusedError):
            tally.refuse(result.images)
            continue
        tally.add(result)
        yield result
    tally.leave_out(reading.unplaced, source.refusals, expected=place.expected)


def _measured(job: Job, item: _Item) -> StationResult | StationRefusedError:
    lines = find_lines(item[0], job)
    try:
        return evaluate_station(swept(lines, item[2], job) if len(item) > 2 else lines, item[1], job)
    except StationRefusedError as refused:
        return refused


def profile_scan(
    scan: Path | str,
    out: Path | str,
    *,
    estimator: str = "zero-crossing",
    workers: Workers | None = None,
    progress: Progress | None = None,
    finisher: Finisher | None = None,
    probe: Probe | Path | str | None = None,
    spacetime: bool = False,
) -> dict[str, Any]:
    """Measure the scan folder `scan`, write the result folder `out` (formats.md, section 4), return its summary.

    `probe`, or its file, is for tactile scans, where it is not the one that scan.toml names. `spacetime`: follow every
    place of the wall through the pictures in which the light sweeps over it, for steps smaller than the line is thick.
    `summary["skipped"]` names the images that could not be used. Raises InputError where nothing can be measured,
    OutputError where the result cannot be written; `out` then is as it was.
    """
    spec = read_scan(Path(scan))
    if spacetime and spec.kind != "forward-looking":
        raise InputError(f"{spec.folder} is a {spec.kind} scan; spacetime analysis is for rings ahead of the camera.")
    of_kind: dict[str, dict[str, Any]] = {"tactile": {"probe": probe}, "forward-looking": {"spacetime": spacetime}}
    options = {"estimator": estimator, "workers": workers or os.cpu_count() or 1, "progress": progress}
    measure = MEASUREMENTS[spec.kind](spec, **options, **of_kind.get(spec.kind, {}))
    with ResultWriter(out, spec) as writer:
        measured = measure(writer)
        folder = writer.seal()
        if finisher:
            finisher(Sealed(folder, spec, measured.rig, measured.summary, measured.example))
        writer.finish(measured.summary)
    return measured.summary


def forward_measurement(
    spec: ScanSpec, *, estimator: str, workers: Workers, progress: Progress | None, spacetime: bool = False
) -> Measurement:
    """The measurement of a forward-looking scan, everything checked that can be before its first image is read."""
    job, source, place = prepare(spec, estimator=estimator)
    sweep = spacetime_reach(source, place, job, where=str(spec.folder)) if spacetime else None

    def measure(writer: ResultWriter) -> Measured:
        tally, example = Tally(), None
        for result in measure_scan(job, source, place, workers=workers, tally=tally, sweep=sweep):
            writer.add(result.profile, result.points, result.row)
            example = example or (result.first_image(), result.lines[0].stripe)
            if progress:
                progress(tally.stations, source.expected_stations)
        if tally.stations == 0:
            raise InputError(tally.nothing_left(spec.folder))
        summary = summarise(spec, job, tally) | ({"spacetime_reach_m": sweep} if spacetime else {})
        return Measured(summary, job.rig, example)

    return measure


MEASUREMENTS: dict[str, Callable[..., Measurement]] = {
    "forward-looking": forward_measurement,
    "side-facing": side_measurement,
    "tactile": tactile_measurement,
}
"""By kind of scan; called with the scan and, by name, estimator, workers and progress (tactile: and probe)."""

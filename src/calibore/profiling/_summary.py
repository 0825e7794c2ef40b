"""What a finished run says of itself: counts, worst stations, noise, warnings."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from platform import python_version
from typing import Any, Protocol

import numpy as np

from calibore import __version__
from calibore.images import Refusal, StationImages
from calibore.lasers import Cone
from calibore.metrics import RingQuantities
from calibore.profiling._job import Job
from calibore.profiling._missing import (
    counted,
    gap_sentences,
    refused_sentence,
    some,
    unlit_sentence,
    unplaced_sentence,
)
from calibore.profiling._rig_table import describe_rig
from calibore.profiling._station import RefusedImage, StationResult
from calibore.scans import RingProfile, ScanSpec
from calibore.status import MEANING, Status

WORST = 10
"""Stations named as the worst."""
LISTED = 1000
"""Refused images listed in the summary; a survey may lose more than that to one cause."""
LOW_FRACTION = 0.5
COMPARED = ("diameter_mean_m", "ovality_f1216_max_percent", "ovality_f1216_min_percent", "deflection_percent")


class ImagesResult(Protocol):
    """What the images of one stop gave; names as in `StationResult`."""

    @property
    def images(self) -> int: ...
    @property
    def unlit(self) -> tuple[int, ...]: ...
    @property
    def refused(self) -> tuple[RefusedImage, ...]: ...
    @property
    def scale(self) -> float: ...
    @property
    def take_correlation(self) -> float: ...


@dataclass
class Tally:
    """Counts what was measured and what could not be; of a station it keeps little more than its number."""

    stations: int = 0
    images: int = 0
    unusable_images: int = 0
    unplaced_images: int = 0
    skipped: list[dict[str, str]] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    flags: dict[str, int] = field(default_factory=dict)
    unlit: dict[int, int] = field(default_factory=dict)
    statuses: np.ndarray = field(default_factory=lambda: np.zeros(max(Status) + 1, dtype=np.int64))
    worst: list[dict[str, Any]] = field(default_factory=list)
    thin: list[int] = field(default_factory=list)
    _scales: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _shared: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _diameters: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    _takes: list[tuple[int, int]] = field(default_factory=list)
    _expected: Collection[int] = ()

    @property
    def refused_images(self) -> int:
        """Images, and frames of a video, that are there but were not measured."""
        return self.unusable_images + self.unplaced_images

    def see(self, images: StationImages) -> None:
        """A station has come from its source. Frames are not numbered by people: what lacks there, the source tells."""
        if images.time_s is None:
            self._takes.append((images.station, len(images.takes)))

    def add(self, result: StationResult) -> None:
        self.add_images(result)
        self.add_ring(result.profile, result.quantities, result.row)

    def add_images(self, result: "ImagesResult") -> None:
        """What became of the images of one stop."""
        self.images += result.images
        for take in result.unlit:
            self.unlit[take] = self.unlit.get(take, 0) + 1
        self.refuse(result.refused)
        self._scales = [self._scales[0] + result.scale, self._scales[1] + 1]
        if np.isfinite(result.take_correlation):
            self._shared = [self._shared[0] + result.take_correlation, self._shared[1] + 1]

    def add_ring(
        self, profile: RingProfile, quantities: RingQuantities, row: Mapping[str, Any], *, expected: float = 1.0
    ) -> None:
        """One row of the profile; `expected`: the share of its positions at which somebody looked."""
        self.stations += 1
        self.statuses += np.bincount(profile.status, minlength=self.statuses.size)
        for flag in quantities.flags:
            self.flags[flag] = self.flags.get(flag, 0) + 1
        diameter = quantities.diameter_mean
        if diameter.u < diameter.value:  # a ring of few points may tell nothing, and says so
            count, total, total_u = self._diameters
            self._diameters = [count + 1, total + diameter.value, total_u + diameter.u]
        if quantities.fraction_measured < LOW_FRACTION * expected:
            self.thin.append(profile.station)
        self._rank(profile, row)

    def _rank(self, profile: RingProfile, row: Mapping[str, Any]) -> None:
        entry = {"station": profile.station, "axial_m": profile.axial}
        entry |= {name: row[name] for key in COMPARED for name in (key, f"u_{key}")}
        self.worst = sorted([*self.worst, entry], key=_badness, reverse=True)[:WORST]

    def refuse(self, images: Sequence[RefusedImage]) -> None:
        """Count images that could not be used, and name the first of them."""
        self.unusable_images += len(images)
        named = [{"image": image.name, "reason": image.reason} for image in images]
        self.skipped += named[: LISTED - len(self.skipped)]

    def leave_out(
        self, unplaced: Sequence[tuple[int, int]], refusals: Sequence[Refusal], *, expected: Collection[int] = ()
    ) -> None:
        """Stations (number, images) that the motion table lacks, frames that the source could not hand out; `expected`:
        the stations of the motion table.
        """
        if unplaced:
            self.left_out.append(unplaced_sentence([station for station, _ in unplaced]))
        self.left_out += [str(refusal) for refusal in refusals]
        self.unplaced_images += sum(images for _, images in unplaced) + sum(refusal.count for refusal in refusals)
        self._expected = expected

    def nothing_left(self, folder: Path) -> str:
        """The sentence for a scan of which nothing could be used."""
        reasons = [f"The first, {one['image']}: {one['reason']}." for one in self.skipped[:1]] + self.left_out
        only = "its only image cannot" if self.refused_images == 1 else f"none of its {self.refused_images} images can"
        return " ".join([f"{folder}: {only} be measured.", *reasons[:1]])

    def gaps(self) -> list[str]:
        """Stations and takes that the numbering of the others, or the motion table, lets one expect."""
        return gap_sentences(self._takes, self._expected)

    @property
    def measured(self) -> int:
        """Positions with a value."""
        return int(self.statuses[[status for status in Status if status.has_value]].sum())

    @property
    def scale(self) -> float:
        return self._scales[0] / max(self._scales[1], 1)

    @property
    def take_correlation(self) -> float | None:
        return self._shared[0] / self._shared[1] if self._shared[1] else None

    @property
    def mean_diameter(self) -> tuple[float, float]:
        """Mean diameter of the pipe and its standard uncertainty [m]: that of one ring, for most of it is common."""
        count, total, total_u = self._diameters
        return (total / count, total_u / count) if count else (float("nan"), float("nan"))


def _badness(row: dict[str, Any]) -> float:
    worst = max(row["ovality_f1216_max_percent"], row["ovality_f1216_min_percent"])
    return worst if np.isfinite(worst) else -1.0


def summarise(spec: ScanSpec, job: Job, tally: Tally) -> dict[str, Any]:
    """The summary of a run as plain data; the same input gives the same summary."""
    measured = tally.measured
    limits = {"deflection_percent": spec.limit_deflection_percent, "ovality_percent": spec.limit_ovality_percent}
    return {
        "command": "profile",
        "versions": {"calibore": __version__, "numpy": np.__version__, "python": python_version()},
        "name": spec.name,
        "nominal_radius_m": spec.nominal_radius,
        "limits": {name: limit for name, limit in limits.items() if limit is not None},
        "estimator": job.estimator,
        "channel": job.channel,
        "rig": describe_rig(job, file=spec.rig_path.name if spec.rig_path else None),
        "counts": {
            "stations": tally.stations,
            "images": tally.images,
            "refused_images": tally.refused_images,
            "positions": int(tally.statuses.sum()),
            "measured": measured,
        },
        "fraction_measured": measured / max(int(tally.statuses.sum()), 1),
        "statuses": {Status(i).name.lower(): int(n) for i, n in enumerate(tally.statuses) if n},
        "flags": dict(sorted(tally.flags.items())),
        "mean_diameter_m": tally.mean_diameter[0],
        "u_mean_diameter_m": tally.mean_diameter[1],
        "scatter_over_model": tally.scale,
        "take_correlation": tally.take_correlation,
        "worst_stations": tally.worst,
        "skipped": tally.skipped,
        "warnings": warnings_of(job, tally),
    }


def warnings_of(job: Job, tally: Tally) -> list[str]:
    """What a reader of the result must know, one sentence each."""
    found = []
    if job.rig.default_uncertainty:
        found.append(
            f"The rig file states no uncertainty of the {_assumed(job)}: +-0.1 % of the nominal radius is assumed, and "
            "everything it does not mention (lens, principal point, tilt) is taken as exactly known."
        )
    if tally.unusable_images:
        found.append(refused_sentence(tally.unusable_images, tally.skipped))
    if tally.unlit:
        found.append(unlit_sentence(tally.unlit))
    found += [*tally.left_out, *tally.gaps()]
    if tally.thin:
        at = "station" if len(tally.thin) == 1 else f"{len(tally.thin)} stations:"
        found.append(f"Less than {100 * LOW_FRACTION:.0f} % of the ring was measured at {at} {some(tally.thin)}.")
    for status in (Status.MULTIPLE, Status.NOT_LASER, Status.OFF_RING, Status.GRAZING):
        count = int(tally.statuses[status])
        if count:
            have = "has" if count == 1 else "have"
            found.append(f"{counted(count, 'position')} {have} no value: {MEANING[status]}.")
    return [*found, *_outside(job, tally)]


def _outside(job: Job, tally: Tally) -> Iterator[str]:
    """That positions were measured where the rig was not calibrated."""
    count = int(tally.statuses[Status.EXTRAPOLATED])
    if count and job.rig.valid is not None:
        yield (
            f"{counted(count, 'position')} ({100 * count / tally.measured:.1f} % of those measured) "
            f"{'lies' if count == 1 else 'lie'} outside the region where the rig was calibrated "
            f"({job.rig.valid.said()}): lens and laser are extrapolated there, and the stated uncertainty may be too "
            "small. Calibrate with a target that reaches as far as the pipe."
        )


def _assumed(job: Job) -> str:
    """Which lengths the default uncertainty is one of."""
    return "baseline and the projection" if any(isinstance(one.surface, Cone) for one in job.rig.lasers) else "baseline"

"""What a finished run says of itself: counts, worst stations, noise, warnings."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from platform import python_version
from typing import Any

import numpy as np

from calibore import __version__
from calibore.images import Refusal
from calibore.profiling._station import Job, StationResult
from calibore.scans import ScanSpec
from calibore.status import MEANING, Status

WORST = 10
"""Stations named as the worst."""
NAMED = 20
"""Refused images named one by one; a survey may lose thousands to one cause."""
LOW_FRACTION = 0.5
COMPARED = ("diameter_mean_m", "ovality_f1216_max_percent", "ovality_f1216_min_percent", "deflection_percent")


@dataclass
class Tally:
    """Counts what was measured and what could not be, station by station, in memory that does not grow with them."""

    stations: int = 0
    images: int = 0
    refused_images: int = 0
    refused: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    flags: dict[str, int] = field(default_factory=dict)
    statuses: np.ndarray = field(default_factory=lambda: np.zeros(max(Status) + 1, dtype=np.int64))
    worst: list[dict[str, Any]] = field(default_factory=list)
    thin: list[int] = field(default_factory=list)
    _scales: float = 0.0
    _shared: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _diameters: list[float] = field(default_factory=lambda: [0.0, 0.0])

    def add(self, result: StationResult) -> None:
        self.stations += 1
        self.images += len(result.takes)
        self._refuse(result.refused)
        self.statuses += np.bincount(result.profile.status, minlength=self.statuses.size)
        for flag in result.quantities.flags:
            self.flags[flag] = self.flags.get(flag, 0) + 1
        self._scales += result.scale
        if len(result.takes) > 1:
            self._shared = [self._shared[0] + result.take_correlation, self._shared[1] + 1]
        if np.isfinite(result.quantities.diameter_mean.value):
            self._diameters = [self._diameters[0] + result.quantities.diameter_mean.value, self._diameters[1] + 1]
        if result.quantities.fraction_measured < LOW_FRACTION:
            self.thin = (self.thin + [result.profile.station])[:NAMED]
        self._rank(result)

    def _rank(self, result: StationResult) -> None:
        row = {"station": result.profile.station, "axial_m": result.profile.axial}
        row |= {name: result.row[name] for key in COMPARED for name in (key, f"u_{key}")}
        self.worst = sorted([*self.worst, row], key=_badness, reverse=True)[:WORST]

    def refuse_station(self, why: str) -> None:
        self._refuse([why])

    def _refuse(self, sentences: Sequence[str]) -> None:
        self.refused_images += len(sentences)
        self.refused = (self.refused + list(sentences))[:NAMED]

    def leave_out(self, unplaced: Sequence[int], refusals: Sequence[Refusal]) -> None:
        """Stations without a place in the motion table, and frames the source could not hand out."""
        if unplaced:
            some = ", ".join(map(str, unplaced[:NAMED])) + (", ..." if len(unplaced) > NAMED else "")
            self.left_out.append(f"{len(unplaced)} stations are not in the motion table and were left out: {some}.")
        self.left_out += [str(refusal) for refusal in refusals]
        self.refused_images += len(unplaced) + sum(refusal.count for refusal in refusals)

    def nothing_left(self, folder: Path) -> str:
        """The sentence for a scan of which nothing could be used."""
        reasons = [*self.refused, *self.left_out]
        first = f" The first: {reasons[0]}" if reasons else ""
        return f"{folder} holds no image that can be measured ({self.refused_images} refused).{first}"

    @property
    def scale(self) -> float:
        return self._scales / max(self.stations, 1)

    @property
    def take_correlation(self) -> float | None:
        return self._shared[0] / self._shared[1] if self._shared[1] else None

    @property
    def diameter_mean(self) -> float:
        return self._diameters[0] / self._diameters[1] if self._diameters[1] else float("nan")


def _badness(row: dict[str, Any]) -> float:
    worst = max(row["ovality_f1216_max_percent"], row["ovality_f1216_min_percent"])
    return worst if np.isfinite(worst) else -1.0


def summarise(spec: ScanSpec, job: Job, tally: Tally) -> dict[str, Any]:
    """The summary of a run as plain data; the same input gives the same summary."""
    measured = int(tally.statuses[: Status.SATURATED + 1].sum())
    return {
        "command": "profile",
        "versions": {"calibore": __version__, "numpy": np.__version__, "python": python_version()},
        "nominal_radius_m": spec.nominal_radius,
        "limit_deflection_percent": spec.limit_deflection_percent,
        "estimator": job.estimator,
        "channel": job.channel,
        "rig": describe_rig(job),
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
        "diameter_mean_m": tally.diameter_mean,
        "scatter_over_model": tally.scale,
        "take_correlation": tally.take_correlation,
        "worst_stations": tally.worst,
        "refused": tally.refused,
        "warnings": warnings_of(job, tally),
    }


def describe_rig(job: Job) -> dict[str, Any]:
    """Configuration, lens and parameters of the rig, with standard uncertainties where they are stated."""
    rig, camera = job.rig, job.rig.camera
    stated = dict(zip(job.covariance.names, job.covariance.u, strict=True))
    values = {f"laser.{n}": getattr(rig.lasers[0].surface, n) for n in rig.lasers[0].surface.parameter_names}
    lens, (u, v) = camera.lens, camera.principal_point
    values |= {"camera.k": lens.k, "camera.c1": lens.c1, "camera.c2": lens.c2, "camera.aspect": camera.aspect}
    values |= {f"camera.polynomial_{2 * i + 3}": p for i, p in enumerate(lens.polynomial)}
    values |= {"camera.principal_point_u": u, "camera.principal_point_v": v}
    return {
        "configuration": rig.configuration,
        "lens": camera.lens.law,
        "image": [camera.width, camera.height],
        "parameters": {name: {"value": float(v), "u": float(stated.get(name, 0.0))} for name, v in values.items()},
        "default_uncertainty": rig.default_uncertainty,
        "stripe_px": rig.stripe,
        "degrees_of_freedom": rig.degrees_of_freedom,
    }


def warnings_of(job: Job, tally: Tally) -> list[str]:
    """What a reader of the result must know, one sentence each."""
    found = []
    if job.rig.default_uncertainty:
        found.append(
            "The rig file states no uncertainty of the baseline: +-0.1 % of the nominal radius is assumed, and everything "
            "it does not mention (lens, principal point, tilt) is taken as exactly known."
        )
    if tally.refused_images:
        more = f"; {NAMED} of them are named" if tally.refused_images > NAMED else ""
        found.append(f"{tally.refused_images} images or stations could not be used{more}.")
    found += [*tally.refused, *tally.left_out]
    for station in tally.thin:
        found.append(f"Station {station}: less than {LOW_FRACTION:.0%} of the ring was measured.")
    for status in (Status.MULTIPLE, Status.NOT_LASER, Status.OFF_RING):
        count = int(tally.statuses[status])
        if count:
            found.append(f"{count} positions have no value: {MEANING[status]}.")
    return found

"""What a finished tactile run says of itself."""

from collections.abc import Iterator
from pathlib import Path
from platform import python_version
from typing import Any

import numpy as np

from calibore import __version__
from calibore.profiling._missing import counted, some
from calibore.profiling._summary import LOW_FRACTION, Tally
from calibore.profiling._tactile._faults import REACH
from calibore.profiling._tactile._readings import Readings
from calibore.profiling._tactile._rings import DEFAULT_DRIFT, Wall
from calibore.rigs import Probe
from calibore.scans import ScanSpec
from calibore.status import MEANING, Status

CONFIGURATION = "tactile-probe"


def summarise_touch(
    spec: ScanSpec, tally: Tally, *, wall: Wall, readings: Readings, probe: Probe, file: Path | None
) -> dict[str, Any]:
    """The summary of a run as plain data; `file`: where the probe comes from."""
    limits = {"deflection_percent": spec.limit_deflection_percent, "ovality_percent": spec.limit_ovality_percent}
    positions, lost = int(tally.statuses.sum()), int(tally.statuses[Status.NO_READING])
    return {
        "command": "profile",
        "versions": {"calibore": __version__, "numpy": np.__version__, "python": python_version()},
        "name": spec.name,
        "nominal_radius_m": spec.nominal_radius,
        "limits": {name: limit for name, limit in limits.items() if limit is not None},
        "rig": _describe(spec, probe, file),
        "counts": {
            "stations": tally.stations,
            "readings": positions - lost,
            "refused_readings": lost + len(readings.left_out) * readings.grid.clock.size,
            "positions": positions,
            "measured": tally.measured,
        },
        "fraction_measured": tally.measured / max(positions, 1),
        "statuses": {Status(i).name.lower(): int(n) for i, n in enumerate(tally.statuses) if n},
        "flags": dict(sorted(tally.flags.items())),
        "mean_diameter_m": tally.mean_diameter[0],
        "u_mean_diameter_m": tally.mean_diameter[1],
        "scatter_over_model": wall.usual / probe.noise if probe.noise > 0 else None,
        "take_correlation": None,
        "worst_stations": tally.worst,
        "skipped": [],
        "warnings": list(_warnings(spec, tally, readings, probe)),
    }


def _describe(spec: ScanSpec, probe: Probe, file: Path | None) -> dict[str, Any]:
    tables = spec.tactile
    u_slope, u_intercept = probe.covariance.u
    drift = DEFAULT_DRIFT if tables is None or tables.drift is None else tables.drift
    values = (
        ("probe.slope", probe.slope, float(u_slope)),
        ("probe.intercept", probe.intercept, float(u_intercept)),
        ("probe.linearity", 0.0, probe.linearity),
        ("probe.noise", 0.0, probe.noise),
        ("tactile.drift", 0.0, float(drift)),
        ("tactile.tip_radius", tables.tip_radius if tables else float("nan"), None),
    )
    return {
        "configuration": CONFIGURATION,
        "file": None if file is None else file.name,
        "parameters": [{"name": name, "value": value, "u": u, "unit": "m"} for name, value, u in values],
        "default_uncertainty": False,
        "degrees_of_freedom": probe.degrees_of_freedom,
        "stroke": list(probe.stroke),
    }


def _warnings(spec: ScanSpec, tally: Tally, readings: Readings, probe: Probe) -> Iterator[str]:
    """What a reader of the result must know, one sentence each."""
    if not probe.covariance.u.any():
        yield (
            "The probe's file states no uncertainty: slope and intercept are taken as exactly known. Calibrate with "
            "`calibore calibrate probe`."
        )
    if spec.tactile is None or spec.tactile.drift is None:
        yield (
            f"[tactile] states no drift of the probe: +-{1e3 * DEFAULT_DRIFT * np.sqrt(3):.4f} mm (0.001 in) during "
            "the scan is assumed. Touch the same spot before and after, and state drift."
        )
    yield from _geometry(readings, spec.nominal_radius)
    if readings.left_out:
        yield f"motion.table has no row for {counted(len(readings.left_out), 'ring')}: {some(readings.left_out)}."
    if tally.thin:
        at = "station" if len(tally.thin) == 1 else f"{len(tally.thin)} stations:"
        yield f"Less than {100 * LOW_FRACTION:.0f} % of the ring was measured at {at} {some(tally.thin)}."
    for status in (Status.STUCK, Status.OFF_TIP, Status.NO_READING):
        count = int(tally.statuses[status])
        if count:
            yield f"{counted(count, 'position')} {'has' if count == 1 else 'have'} no value: {MEANING[status]}."
    beyond = int(tally.statuses[Status.EXTRAPOLATED])
    if beyond:
        low, high = probe.stroke
        yield (
            f"{counted(beyond, 'position')} {'lies' if beyond == 1 else 'lie'} outside the stroke where the probe was "
            f"calibrated (ratio {low:.3g} to {high:.3g}): the line is extrapolated there. Calibrate over the whole "
            "stroke in use."
        )


def _geometry(readings: Readings, nominal_radius: float) -> Iterator[str]:
    """That stops or rings are too far apart to tell what the ball touches."""
    grid = readings.grid
    reach = REACH * grid.tip_radius
    if grid.axial.size == 1:
        yield "There is one ring only: the wall is taken as straight along the pipe under the probe's ball."
    rings = float(np.min(np.abs(np.diff(grid.axial)), initial=np.inf))
    for name, apart in (("stops", grid.step * nominal_radius), ("rings", rings)):
        if reach < apart < np.inf:
            yield (
                f"The {name} are {1e3 * apart:.3g} mm apart, more than {REACH:g} tip radii: along them no stuck pin "
                "and no edge can be told, and the slope under the ball is known only as far as the wall is smooth."
            )

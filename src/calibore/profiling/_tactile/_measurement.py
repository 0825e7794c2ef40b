"""The measurement of a tactile scan: voltages in, a measured pipe out."""

from pathlib import Path

import numpy as np

from calibore.errors import InputError
from calibore.profiling._measured import Measured, Measurement, Progress
from calibore.profiling._summary import Tally
from calibore.profiling._tactile._readings import Readings, read_readings
from calibore.profiling._tactile._rings import DEFAULT_DRIFT, measure_wall, rings_of
from calibore.profiling._tactile._summary import summarise_touch
from calibore.rigs import Probe, read_probe
from calibore.scans import ResultWriter, ScanSpec


def tactile_measurement(
    spec: ScanSpec,
    *,
    estimator: str = "",
    workers: int = 1,
    progress: Progress | None = None,
    probe: Probe | Path | str | None = None,
) -> Measurement:
    """The measurement of a tactile scan, everything checked that can be before the result is begun; `probe` where not
    the one that scan.toml names. Estimator and workers are for pictures.
    """
    del estimator, workers
    if spec.tactile is None:
        raise InputError(f"{spec.folder} is no tactile scan; [tactile] in its scan.toml names the probe's tables.")
    tables = spec.tactile
    file = Path(probe) if isinstance(probe, Path | str) else tables.probe if probe is None else None
    known = probe if isinstance(probe, Probe) else read_probe(_named(file, spec))
    readings = read_readings(spec, tables)
    _check_size(readings, known, spec)

    def measure(writer: ResultWriter) -> Measured:
        wall = measure_wall(readings, known, drift=DEFAULT_DRIFT if tables.drift is None else tables.drift)
        tally, total = Tally(), len(readings.stations)
        for ring in rings_of(wall, readings, nominal_radius=spec.nominal_radius):
            writer.add(ring.profile, ring.points, ring.row)
            tally.add_ring(ring.profile, ring.quantities, ring.row)
            if progress:
                progress(tally.stations, total)
        summary = summarise_touch(spec, tally, wall=wall, readings=readings, probe=known, file=file)
        return Measured(summary, None, None)

    return measure


def _named(file: Path | None, spec: ScanSpec) -> Path:
    if file is None:
        raise InputError(
            f'{spec.folder / "scan.toml"}: [tactile] names no probe; add probe = "probe.toml", which `calibore '
            "calibrate probe` makes from a caliper's lengths and diameters."
        )
    return file


def _check_size(readings: Readings, probe: Probe, spec: ScanSpec) -> None:
    """A probe or pipe of another size is told before anything is measured."""
    radius = probe.radius(readings.ratio)
    middle = float(np.nanmedian(radius))
    low, high = (share * spec.nominal_radius for share in (spec.search_inner, spec.search_outer))
    if not low <= middle <= high:
        raise InputError(
            f"By its calibration the probe reaches {1e3 * middle:.4g} mm from its axis, in a pipe of nominal radius "
            f"{1e3 * spec.nominal_radius:.4g} mm; check the unit of pipe.nominal_radius, and whether it is this "
            "probe's calibration."
        )
    if np.nanmin(radius) <= readings.grid.tip_radius:
        raise InputError(
            f"The probe's shortest reading is {1e3 * float(np.nanmin(radius)):.4g} mm from its axis, less than "
            "tactile.tip_radius; check tip_radius and the probe's calibration."
        )

"""Kind "probe": from voltages and a caliper's readings to the radius that a probe touches (Swanbom 2007, 8.2.3).

The slope comes from lengths measured under the caliper, whose origin is arbitrary; the intercept from diameters in the
pipe. The tip's radius is no part of it: which spot a ball touches is the scan's business.
"""

from collections.abc import Callable
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._probe._diameters import Intercept, intercepts
from calibore.calibration._probe._line import Line, fit_line
from calibore.calibration._probe._tables import ProbeTables, read_probe_tables
from calibore.calibration._probe._words import findings, warnings
from calibore.errors import InputError
from calibore.rigs import Probe
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
NAMES = ("probe.slope", "probe.intercept")
LENGTHS = ("slope", "intercept", "noise", "linearity")
ORIGIN = "probe.length_origin"


def calibrate_probe(path: Path | str, *, progress: Callable[[int, int], None] | None = None) -> Calibration:
    """The probe from the tables that `path`, a target.toml or its folder, names. Raises InputError where they do not
    hold what is needed.
    """
    tables = read_probe_tables(Path(path))
    line = fit_line(tables.ratio, tables.length)
    probe, intercept = probe_of(tables, line)
    if progress is not None:
        progress(1, 1)
    return Calibration(
        kind=tables.target.kind,
        rig=None,
        camera=None,
        values=dict(zip(NAMES, (probe.slope, probe.intercept), strict=True)),
        covariance=probe.covariance,
        degrees_of_freedom=probe.degrees_of_freedom,
        noise=line.scatter,
        group_sigma=0.0,
        files=tables.files,
        observations=_observations(tables, line, intercept, probe),
        settings={"probe": {**{key: f"{getattr(probe, key)!r} m" for key in LENGTHS}, "stroke": list(probe.stroke)}},
        findings=tuple(findings(tables, line, intercept, probe)),
        warnings=tuple(warnings(tables, line, intercept)),
    )


def probe_of(tables: ProbeTables, line: Line) -> tuple[Probe, Intercept]:
    """The probe, and how its intercept was found."""
    if line.slope == 0:
        raise InputError("The caliper's lengths do not depend on the ratio; check which column of the table is which.")
    target = tables.target
    digit = abs(line.slope) * target.u_digit
    noise = float(np.sqrt(max(line.scatter**2 - target.u_caliper**2, digit**2)))
    readings = 2 * noise**2
    variance = np.full(tables.diameter.size, target.u_caliper**2 + readings + 2 * target.u_contact**2)
    intercept = intercepts(
        line.slope,
        tables.raw,
        tables.diameter,
        u_diameter=np.sqrt(variance),
        freedom=_effective([(readings, line.freedom), (variance[0] - readings, inf)]),
    )
    by_slope = intercept.mean_ratio * line.u_slope
    shared = -intercept.mean_ratio * line.u_slope**2
    freedom = _effective([(intercept.u**2, intercept.freedom), (by_slope**2, line.freedom)])
    covariance = Covariance(
        NAMES,
        [[line.u_slope**2, shared], [shared, intercept.u**2 + by_slope**2]],
        degrees_of_freedom=[line.freedom, freedom],
    )
    least = min(line.freedom, freedom)
    return Probe(line.slope, intercept.value, covariance, noise, least, line.bend, line.stroke), intercept


def _effective(parts: list[tuple[float, float]]) -> float:
    """Degrees of freedom of a sum of variances, each with its own (Welch and Satterthwaite, JCGM 100, G.4)."""
    doubt = sum(variance**2 / freedom for variance, freedom in parts)
    return sum(variance for variance, _ in parts) ** 2 / doubt if doubt > 0 else inf


def _observations(tables: ProbeTables, line: Line, intercept: Intercept, probe: Probe) -> Observations:
    """Lengths, then diameters, against slope, origin of the lengths and intercept."""
    n, m = tables.ratio.size, tables.diameter.size
    lengths = np.stack([tables.ratio, np.ones(n), np.zeros(n)], axis=1)
    diameters = np.stack([tables.raw.sum(axis=1), np.zeros(m), np.full(m, 2.0)], axis=1)
    return Observations(
        file=np.repeat([0, 1], [n, m]),
        u=np.full(n + m, np.nan),
        v=np.full(n + m, np.nan),
        residual=np.concatenate([line.residuals, 2 * (intercept.each - intercept.value)]),
        sigma=np.concatenate([np.full(n, line.scatter), 2 * intercept.u_each]),
        weight=np.concatenate([np.ones(n), intercept.kept.astype(float)]),
        group=np.arange(n + m),
        jacobian=np.concatenate([lengths, diameters]),
        names=(NAMES[0], ORIGIN, NAMES[1]),
        unit="m",
        whitened=_root(line, probe, intercept, n),
    )


def _root(line: Line, probe: Probe, intercept: Intercept, n: int) -> Array:
    """(3, 3) whose inverse square is the covariance of slope, origin and intercept."""
    covariance = np.zeros((3, 3))
    covariance[np.ix_([0, 2], [0, 2])] = probe.covariance.matrix
    by_origin = -line.mean_ratio * line.u_slope**2
    covariance[0, 1] = covariance[1, 0] = by_origin
    covariance[1, 2] = covariance[2, 1] = -intercept.mean_ratio * by_origin
    covariance[1, 1] = line.scatter**2 * line.stretch / n + line.mean_ratio**2 * line.u_slope**2
    scale = np.sqrt(np.diag(covariance))
    return np.linalg.cholesky(np.linalg.inv(covariance / np.outer(scale, scale))).T / scale

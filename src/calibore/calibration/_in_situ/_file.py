"""target.toml of kind "profile": a scan and, in the same pipe, a reference that is known better."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from calibore.calibration._in_situ._wall import WallGrid
from calibore.calibration._in_words import Unit
from calibore.calibration._input_files import InputFile, input_file
from calibore.calibration._pupil._target import LengthText
from calibore.documents import Angle, Document, FileName, Length, read_document
from calibore.errors import InputError
from calibore.rigs import Probe, Rig, read_probe, read_rig
from calibore.scans import AxialMotion, ScanSpec, read_scan
from calibore.units import parse_quantity

Array = NDArray[np.float64]
Positive = Annotated[Length, Field(gt=0)]
REFERENCES = ("gauge", "reference", "tactile")
DEFAULT_U = 0.0005 * 0.0254
"""m; shared by all radii of a reference that says nothing of its uncertainty: a caliper's."""
COLUMNS = ("axial_m", "clock_rad", "radius_m", "u_m")
LARGEST = 1e6
"""m, rad, V."""
FEWEST_FILLED = 0.5
"""Fraction of a table's axial and clock positions that must hold a radius, if it is a grid."""


class ProfileFile(Document):
    """`u_reference`: standard uncertainty that all radii of the reference share; `u_roll`, `u_axial`: how well its
    frame is known to lie in the scan's. `stations`: those to use; `free`: the parameters to look for.
    """

    format: Literal["calibore-target/1"]
    kind: Literal["profile"]
    rig: FileName
    profile: FileName | None = None
    scan: FileName | None = None
    gauge: LengthText | None = None
    reference: FileName | None = None
    tactile: FileName | None = None
    probe: FileName | None = None
    u_reference: Annotated[Length, Field(ge=0)] | None = None
    u_roll: Annotated[Angle, Field(gt=0)] = float(np.radians(3.0))
    u_axial: Positive = 0.25 * 0.0254
    u_slope: Annotated[Angle, Field(gt=0)] = float(np.radians(0.3))
    prior: bool = False
    free: tuple[str, ...] | None = None
    stations: tuple[int, ...] | None = None


@dataclass(frozen=True, eq=False)
class ProfileTarget:
    """What was `said` in `path`; the `rig` in use; the reference `wall`, one ring for a gauge; the `unit` for people;
    the `files` looked at so far.
    """

    path: Path
    said: ProfileFile
    rig: Rig
    wall: WallGrid
    unit: Unit
    files: tuple[InputFile, ...]

    @property
    def folder(self) -> Path:
        return self.path.parent

    @property
    def is_gauge(self) -> bool:
        return self.said.gauge is not None


def read_profile_target(path: Path | str) -> ProfileTarget:
    """The target file `path`, or target.toml in that folder; raises InputError saying what is missing."""
    path = Path(path)
    path = path / "target.toml" if path.is_dir() else path
    said = read_document(path, ProfileFile)
    if (said.profile is None) == (said.scan is None):
        raise InputError(
            f"{path}: give either profile, a result folder of `calibore profile`, or scan, the scan.toml of a "
            "side-facing head."
        )
    named = [key for key in REFERENCES if getattr(said, key) is not None]
    if len(named) != 1:
        raise InputError(f"{path}: {', '.join(named) or 'nothing'} is given as reference; give one of {_either()}.")
    if (said.tactile is None) != (said.probe is None):
        raise InputError(f"{path}: tactile, a scan folder, and probe, its calibration, belong together; give both.")
    wall, used = _reference(said, path.parent)
    rig = path.parent / said.rig
    unit = Unit.of_length(said.gauge) if said.gauge else Unit("in", 0.0254) if _inches(path, rig) else Unit("mm", 1e-3)
    return ProfileTarget(path, said, read_rig(rig), wall, unit, tuple(input_file(one) for one in (rig, *used)))


def _either() -> str:
    return (
        'gauge = "12.000 in" (a round of known diameter), reference = "table.csv" and tactile = "folder" with probe = '
        '"probe.toml"'
    )


def _inches(*paths: Path) -> bool:
    return any(' in"' in path.read_text(encoding="utf-8", errors="replace") for path in paths if path.is_file())


def _reference(said: ProfileFile, folder: Path) -> tuple[WallGrid, list[Path]]:
    u = said.u_reference
    if said.gauge is not None:
        radius = parse_quantity(said.gauge, "length") / 2
        if radius <= 0:
            raise InputError(f'gauge = "{said.gauge}" must be the positive diameter of a round.')
        clock = np.arange(16) * np.pi / 8
        return WallGrid(np.zeros(1), clock, np.full((1, 16), radius), DEFAULT_U / 2 if u is None else u), []
    if said.reference is not None:
        return read_table(folder / said.reference, u=u), [folder / said.reference]
    scan, probe = read_scan(folder / str(said.tactile)), folder / str(said.probe)
    if scan.tactile is None:
        raise InputError(f"{scan.folder} is a {scan.kind} scan; tactile names a folder with tables of probe voltages.")
    wall = tactile_wall(scan, read_probe(probe), u=u)
    return wall, [scan.tactile.signal, scan.tactile.bias, probe]


def tactile_wall(scan: ScanSpec, probe: Probe, *, u: float | None = None) -> WallGrid:
    """The wall that a probe touched, from signal and bias voltages; raises InputError where they are no such tables."""
    assert scan.tactile is not None
    signal, bias = (_voltages(path) for path in (scan.tactile.signal, scan.tactile.bias))
    if signal.shape != bias.shape:
        raise InputError(f"{scan.tactile.signal} has {signal.shape} voltages, {scan.tactile.bias} {bias.shape}.")
    if not isinstance(scan.motion, AxialMotion) or scan.angular is None:
        raise InputError(f"{scan.folder}: a tactile reference needs motion.axial and motion.angular in its scan.toml.")
    ratio = signal / np.where(bias > 0, bias, np.nan)
    axial, clock = scan.motion.axial(np.arange(len(signal))), scan.angular.clock(np.arange(signal.shape[1]))
    columns = np.argsort(clock % (2 * np.pi), kind="stable")
    rows = np.argsort(axial, kind="stable")
    radius = probe.radius(ratio)[np.ix_(rows, columns)]
    shared = float(probe.common_modes(probe.anchor)[0]) if u is None else u
    bends, pivot = bends_of(probe), float(probe.radius(probe.anchor))
    return WallGrid(axial[rows], clock[columns] % (2 * np.pi), radius, shared, bends, pivot)


def bends_of(probe: Probe) -> Array:
    """Causes (k, 2) by which all radii of a probe may be wrong together, as polynomials of the radius from that at the
    anchor: its slope, and the bend of its line.
    """
    half, middle = (probe.stroke[1] - probe.stroke[0]) / 2, sum(probe.stroke) / 2
    slope = [float(probe.covariance.u[0]) / probe.slope, 0.0]
    place, step = (probe.anchor - middle) / half, 1 / (probe.slope * half)
    bend = [1.5 * probe.linearity * 2 * place * step, 1.5 * probe.linearity * step**2]
    return np.array([cause for cause in (slope, bend) if any(cause)]).reshape(-1, 2)


def read_table(path: Path, *, u: float | None = None) -> WallGrid:
    """A table of axial_m, clock_rad, radius_m and perhaps u_m, the uncertainty that its radii share."""
    rows = _numbers(path)
    if rows.ndim != 2 or rows.shape[1] not in (3, 4) or len(rows) < 8:
        raise InputError(f"{path} needs rows of {', '.join(COLUMNS[:3])} and perhaps u_m, separated by commas.")
    axial, i = np.unique(np.round(rows[:, 0], 9), return_inverse=True)
    clock, j = np.unique(np.round(rows[:, 1] % (2 * np.pi), 9), return_inverse=True)
    told = np.isfinite(rows[:, 2]).sum()
    if told < FEWEST_FILLED * axial.size * clock.size:
        raise InputError(
            f"{path} is no grid: its {len(rows)} rows have {axial.size} axial and {clock.size} clock positions; "
            "measure or interpolate every ring at the same clock positions."
        )
    radius = np.full((axial.size, clock.size), np.nan)
    radius[i, j] = rows[:, 2]
    stated = float(np.median(rows[:, 3])) if rows.shape[1] == 4 else DEFAULT_U
    return WallGrid(axial, clock, radius, stated if u is None else u)


def _voltages(path: Path) -> Array:
    return np.atleast_2d(_numbers(path))


def _numbers(path: Path) -> Array:
    """A table of numbers separated by commas, a heading line allowed; empty cells are NaN."""
    try:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
        body = [line for line in lines if not line.lstrip().startswith("#") and "_" not in line]
        table = np.array([[float(cell) if cell.strip() else np.nan for cell in line.split(",")] for line in body])
    except FileNotFoundError:
        raise InputError(f"{path} is not there; copy the table there, or name it in target.toml.") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read as a table of numbers ({error}); separate them by commas.") from error
    if (np.abs(table) > LARGEST).any():
        raise InputError(
            f"{path} needs rows of numbers, but {np.nanmax(np.abs(table)):g} is beyond any length [m], angle [rad] or "
            "voltage [V]; correct it."
        )
    return table

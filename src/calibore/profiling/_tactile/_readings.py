"""The readings of a probe as ratios at known places: what scan.toml says of a tactile scan, found out and checked."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.images import read_station_table
from calibore.profiling._placement import Placement
from calibore.profiling._tactile._neighbours import Grid
from calibore.profiling._tactile._voltages import read_ratio
from calibore.scans import AngularMotion, ScanSpec, TactileTables

Array = NDArray[np.float64]
TURN = 2 * np.pi
SAME = 0.1
"""Of a step: by how much the stops of a ring may miss a whole turn."""


@dataclass(frozen=True, eq=False)
class Readings:
    """`ratio` (n, m) of signal to bias, NaN where there is none, columns sorted by the clock of `grid`; row numbers
    `stations` of the table and their `placements`; `left_out`: rows that the motion table does not know.
    """

    ratio: Array
    grid: Grid
    stations: tuple[int, ...]
    placements: tuple[Placement, ...]
    left_out: tuple[int, ...] = ()


def read_readings(spec: ScanSpec, tables: TactileTables) -> Readings:
    """Everything of a tactile scan but the probe; raises InputError where it is not usable."""
    toml = spec.folder / "scan.toml"
    if spec.angular is None:
        raise InputError(
            f'{toml} does not say where the probe\'s stops are; add e.g. angular = {{ origin = "0 deg", step = "0.9 '
            'deg" } to [motion].'
        )
    ratio = read_ratio(tables)
    clock, order = _stops(spec.angular, ratio.shape[1], toml=toml, table=tables.signal)
    placed = _placements(spec, len(ratio))
    if not placed:
        raise InputError(f"{spec.motion} has no row for any of the {len(ratio)} rings of {tables.signal.name}.")
    axial = np.array([one.axial for one in placed.values()])
    if axial.size > 1 and not ((np.diff(axial) > 0).all() or (np.diff(axial) < 0).all()):
        raise InputError(f"{spec.motion}: axial_m must go one way from ring to ring; sort rings and table alike.")
    rows = np.array(list(placed), dtype=np.intp)
    return Readings(
        ratio=ratio[rows][:, order],
        grid=Grid(clock, axial, tables.tip_radius),
        stations=tuple(placed),
        placements=tuple(placed.values()),
        left_out=tuple(row for row in range(len(ratio)) if row not in placed),
    )


def _stops(motion: AngularMotion, count: int, *, toml: Path, table: Path) -> tuple[Array, NDArray[np.intp]]:
    """Clock (m,) [rad], increasing, of the stops of a whole turn, and the column of each."""
    if abs(count * abs(motion.step) - TURN) > SAME * abs(motion.step) or count < 8:
        raise InputError(
            f"{table.name} has {count} stops a ring, which {np.degrees(abs(motion.step)):g} deg apart make "
            f"{np.degrees(count * abs(motion.step)):g} deg instead of 360 deg; correct motion.angular in {toml}, or "
            "complete the rows."
        )
    step = TURN / count
    first = float(np.mod(motion.origin, step))
    first = 0.0 if min(first, step - first) < 1e-9 else first
    position = np.rint((motion.origin + np.sign(motion.step) * step * np.arange(count) - first) / step).astype(np.intp)
    clock = np.asarray(first + step * np.arange(count), dtype=np.float64)
    return clock, np.argsort(position % count)


def _placements(spec: ScanSpec, count: int) -> dict[int, Placement]:
    """Where the probe stood at each ring, by row of the table from 0; rows not in the motion table are missing."""
    if not isinstance(spec.motion, Path):
        return {row: Placement(float(spec.motion.axial(row))) for row in range(count)}
    table = read_station_table(spec.motion)
    found = {}
    for row in range(count):
        one = table.get(row)
        if one is not None:
            time = float("nan") if one.time is None else one.time
            found[row] = Placement(one.axial, one.roll, one.pitch, one.yaw, time)
    return found

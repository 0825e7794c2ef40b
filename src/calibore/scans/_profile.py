"""A measured wall in memory: what every instrument's result is, whoever compares it."""

import datetime
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.scans._results import damage_told, open_profile
from calibore.status import has_value

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Profile:
    """R(axial, clock): n rings, m clock positions [rad] rising within one turn, q common modes; SI units.

    `axial` (n,) of the rings; `radius`, `axial_position` of the wall points, `u_independent` (n, m), NaN where nothing
    was measured; cov(radius) = diag(u_independent^2) + sum over `common_mode` (q, n, m) of m m^T; `correlation` (n, k)
    of the independent part at lags of 1 .. k clock steps; `status` (n, m). `sampled`: a point is the wall at its clock
    (a head, a probe), not a mean over the clock step; `date` of the survey, where known. Raises InputError where shapes
    disagree or nothing was measured at all.
    """

    axial: Array
    clock: Array
    radius: Array
    axial_position: Array
    u_independent: Array
    common_mode: Array
    correlation: Array
    status: NDArray[np.uint8]
    name: str = ""
    nominal_radius: float = float("nan")
    sampled: bool = False
    date: datetime.date | None = None

    def __post_init__(self) -> None:
        shape = (self.axial.size, self.clock.size)
        for name in ("radius", "axial_position", "u_independent", "status"):
            if getattr(self, name).shape != shape:
                raise InputError(f"A profile's {name} has shape {shape}, got {getattr(self, name).shape}.")
        if self.common_mode.shape[1:] != shape:
            raise InputError(f"A profile's common_mode has shape (q, {shape[0]}, {shape[1]}).")
        if not np.isfinite(self.radius).any():
            raise InputError(f"The profile{f' {self.name}' if self.name else ''} holds no radius at all.")

    @cached_property
    def measured(self) -> NDArray[np.bool_]:
        """(n, m) where there is a radius."""
        return np.isfinite(self.radius) & has_value(self.status)

    @property
    def u_common(self) -> Array:
        """(n, m) [m]"""
        return np.where(np.isnan(self.radius), np.nan, np.sqrt(np.sum(self.common_mode**2, axis=0)))

    @property
    def typical_radius(self) -> float:
        """m; the median."""
        return float(np.nanmedian(self.radius))

    @property
    def spacing(self) -> float:
        """Between rings [m]; 0 of a single ring."""
        return float(np.median(np.diff(np.sort(self.axial)))) if self.axial.size > 1 else 0.0

    def rings(self, rows: NDArray[np.integer] | slice) -> "Profile":
        """Some of the rings only."""
        own = ("axial", "radius", "axial_position", "u_independent", "correlation", "status")
        return replace(self, **{name: getattr(self, name)[rows] for name in own}, common_mode=self.common_mode[:, rows])


def joined(profiles: Sequence[Profile]) -> Profile:
    """One profile of sections of one scan, measured with one rig file: their common modes are the same parameters'.

    Where sections overlap, of two rings nearer than half the spacing the one with more points stays. Raises InputError
    where clock positions or the number of modes differ.
    """
    first = profiles[0]
    if any(
        one.clock.shape != first.clock.shape
        or not np.allclose(one.clock, first.clock, atol=1e-9)
        or len(one.common_mode) != len(first.common_mode)
        or one.correlation.shape[1] != first.correlation.shape[1]
        for one in profiles
    ):
        raise InputError("Sections can be joined where clock positions and rig file are the same for all of them.")
    columns = ("axial", "radius", "axial_position", "u_independent", "correlation", "status")
    stacked = {name: np.concatenate([getattr(one, name) for one in profiles]) for name in columns}
    modes = np.concatenate([one.common_mode for one in profiles], axis=1)
    whole = replace(first, **stacked, common_mode=modes)
    return whole.rings(_of_each_place(whole, min(one.spacing for one in profiles) / 2))


def _of_each_place(profile: Profile, apart: float) -> NDArray[np.intp]:
    """Rows, rising along the axis, of which none is nearer to the next than `apart` [m]."""
    kept: list[int] = []
    points = profile.measured.sum(axis=1)
    for row in np.argsort(profile.axial, kind="stable").tolist():
        if kept and profile.axial[row] - profile.axial[kept[-1]] < apart:
            if points[row] > points[kept[-1]]:
                kept[-1] = row
        else:
            kept.append(row)
    return np.array(kept, dtype=np.intp)


def read_profile(out: Path | str) -> Profile:
    """The profile of the result folder `out`; rings without any radius are left out. Raises InputError."""
    stored = open_profile(out)
    if "noise_correlation" not in stored:
        raise InputError(f"{out} was written by an early version, without noise_correlation; run the profile again.")
    with damage_told(Path(out) / "profile.zarr"):
        return _read(stored, out)


def _read(stored: "xarray.Dataset", out: Path | str) -> Profile:
    columns = {
        name: np.asarray(stored[name], dtype=float)
        for name in ("axial", "clock", "radius", "axial_position", "u_independent", "common_mode", "noise_correlation")
    }
    columns["correlation"] = columns.pop("noise_correlation")
    said, day = stored.attrs, stored.attrs.get("scan_date")
    rows = np.flatnonzero(np.isfinite(columns["radius"]).any(axis=1))
    if rows.size == 0:
        raise InputError(f"{out} holds no radius at all; nothing was measured there.")
    whole = Profile(
        **columns,
        status=np.asarray(stored["status"]),
        name=str(said.get("title", "")),
        nominal_radius=float(said.get("nominal_radius", np.nan)),
        sampled=said.get("scan_kind", "forward-looking") != "forward-looking",
        date=None if day is None else datetime.date.fromisoformat(str(day)),
    )
    return whole.rings(rows[np.argsort(columns["axial"][rows], kind="stable")])

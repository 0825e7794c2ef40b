"""Two profiles, the question asked of them, and everything found."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._agreement import Agreement, Errors, OutlierRule, agreement, errors_of
from calibore.comparison._changes import FALSE_ALARM, Changes, changes
from calibore.comparison._checks import Names, check_outcome, check_pair, comparable, why_not_registered
from calibore.comparison._difference import Difference, difference
from calibore.errors import InputError
from calibore.registration import Motion, Registration
from calibore.scans import Profile

Array = NDArray[np.float64]
OUTLIER = 0.15 * 0.0254
"""m; what the dissertation calls an outlier (8.4.1)."""


@dataclass(frozen=True, eq=False)
class Compared:
    """`moving` brought onto `reference` and compared; `names` of both, as people call them.

    `changes` is None where the question was the error of a measurement; `agreement` is there for both. `years` between
    two epochs, where dates are known. `warnings`: sentences.
    """

    moving: Profile
    reference: Profile
    names: Names
    difference: Difference
    agreement: Agreement
    changes: Changes | None
    years: float | None
    warnings: tuple[str, ...]

    @property
    def registration(self) -> Registration:
        return self.difference.registration

    @property
    def value(self) -> Array:
        """(n, m) [m]: the error, or the change without what calibration explains."""
        return self.difference.value if self.changes is None else self.difference.adjusted

    @property
    def u(self) -> Array:
        """(n, m) [m] standard uncertainty of `value`."""
        return self.difference.u if self.changes is None else self.difference.u_adjusted

    @property
    def normalised(self) -> Array:
        """(n, m): En of errors, significance of changes."""
        return self.agreement.normalised if self.changes is None else self.changes.significance

    @property
    def axial(self) -> Array:
        """(n,) [m] of the moving profile's rings along the reference; NaN where a ring has no counterpart."""
        known = np.isfinite(self.difference.axial).any(axis=1)
        axial = np.full(known.size, np.nan)
        axial[known] = np.nanmedian(self.difference.axial[known], axis=1)
        return axial

    @property
    def clock(self) -> Array:
        """(m,) [rad] of the moving profile's clock positions on the reference; single points: `difference.clock`."""
        return np.mod(self.moving.clock + self.registration.motion.roll, 2 * np.pi)

    def away_from_edges(self, row: int | None = None) -> Errors:
        """Errors of points, of all rings or of one `row`, where noise is more than what an edge may hide."""
        rows = slice(None) if row is None else slice(row, row + 1)
        one = self.difference
        known = np.isfinite(self.value) & np.isfinite(self.u) & (np.nan_to_num(one.missed) <= one.u_independent)
        return errors_of(self.value, self.u, known[rows], np.zeros_like(known[rows]), place=one.axial, rows=rows)

    @property
    def rings(self) -> dict[int, Errors]:
        """What is left on every ring that could be compared, by its row."""
        value, u, axial = self.value, self.u, self.difference.axial
        known = np.isfinite(value) & np.isfinite(u)
        outlier = known & self.agreement.rule.outliers(np.nan_to_num(value), np.nan_to_num(u))
        if self.changes is not None:
            outlier = np.zeros_like(known)
        rows = [row for row in range(len(value)) if known[row].any()]
        return {
            row: errors_of(
                value, u, known[row : row + 1], outlier[row : row + 1], place=axial, rows=slice(row, row + 1)
            )
            for row in rows
        }


def compared(
    moving: Profile,
    reference: Profile,
    *,
    epochs: bool,
    names: Names = ("the measurement", "the reference"),
    rule: OutlierRule | None = None,
    false_alarm: float = FALSE_ALARM,
    years: float | None = None,
    **alignment: Any,
) -> Compared:
    """Registers, compares, and asks for change between `epochs` or else for errors; `alignment` as for `difference`.

    Raises InputError where the two cannot be compared: other units, other pipes, mirrored, no common points.
    """
    check_pair(moving, reference, names)
    common = comparable(moving, reference, alignment.get("start"))
    try:
        found = difference(moving, reference, **alignment)
    except InputError as error:
        raise why_not_registered(moving, reference, names, common=common, error=error) from error
    warnings = check_outcome(found, moving, reference, names, common=common)
    return Compared(
        moving,
        reference,
        names,
        found,
        agreement(found, rule or OutlierRule(limit=OUTLIER)),
        changes(found, false_alarm=false_alarm) if epochs else None,
        years,
        (*warnings, *_alignment_words(found.registration)),
    )


def _alignment_words(registration: Registration) -> tuple[str, ...]:
    untold = [name for name in registration.untold if name in Motion.names]
    if not untold:
        return ()
    known = {
        name: f"+-{np.degrees(1.96 * registration.u(name)):.2g} deg"
        if name in ("roll", "tilt_x", "tilt_y")
        else f"+-{100 * 1.96 * registration.u(name):.2g} %"
        if name in ("stretch", "scale")
        else f"+-{1e3 * 1.96 * registration.u(name):.2g} mm"
        for name in untold
    }
    said = ", ".join(f"{name.replace('_', ' ')} ({interval})" for name, interval in known.items())
    return (f"The profiles do not tell this of the alignment, too little of the wall depends on it: {said}.",)

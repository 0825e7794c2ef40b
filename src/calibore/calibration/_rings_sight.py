"""The marks of all ring photographs together, line by line, and what is known of them before any fit."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rings_model import Printed
from calibore.targets import RingMarks

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

GAP = 1.6
"""Marks farther apart than this many times what is usual on their line are not neighbours."""
STRETCHES = 24
"""Into how many stretches a line is divided where models are compared."""
AGREEING = 4.0
"""Robust standard deviations from the others of its stretch within which a mark counts."""
TO_DEVIATION = 1.4826
"""Median of |x| to standard deviation of normal x."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What is `printed`, the `marks` of each picture, the image `size` (width, height) [px], the `nominal_baseline` [m]
    of the first picture; `u_ring` [m] of printed radii, None where the marks shall tell; what is known of the camera.
    """

    printed: Printed
    marks: tuple[RingMarks, ...]
    size: tuple[int, int]
    nominal_baseline: float
    u_ring: float | None = None
    principal_point: tuple[float, float] | None = None
    square: bool = False

    @cached_property
    def picture(self) -> Whole:
        """(n,) the picture of each mark."""
        return np.repeat(np.arange(len(self.marks)), [marks.u.size for marks in self.marks])

    @cached_property
    def line(self) -> Whole:
        """(n,) the line of each mark: rings from 1, then spokes."""
        rings = self.printed.radii.size
        return np.concatenate([np.where(marks.ring > 0, marks.ring, rings + 1 + marks.spoke) for marks in self.marks])

    @cached_property
    def sight_of_line(self) -> Whole:
        """(n,) the line in its picture, numbered through all pictures."""
        return self.picture * (self.printed.radii.size + self.printed.spokes + 1) + self.line

    @cached_property
    def sigma(self) -> Array:
        return np.concatenate([marks.sigma for marks in self.marks])

    @cached_property
    def places(self) -> Array:
        """(n, 2) [px]."""
        return np.concatenate([np.stack([marks.u, marks.v], axis=1) for marks in self.marks])

    @cached_property
    def chains(self) -> Whole:
        """(n,) marks that follow one another along a line without a gap."""
        step = np.hypot(*np.diff(self.places, axis=0).T)
        apart = np.diff(self.sight_of_line) != 0
        for line in np.unique(self.sight_of_line):
            along = ~apart & (self.sight_of_line[1:] == line)
            if along.any():
                apart |= along & (step > GAP * np.median(step[along]))
        return np.concatenate([[0], np.cumsum(apart)]).astype(np.intp)

    def of(self, rows: Whole, shift: Array) -> "Sight":
        """The marks `rows` (m,) only, moved by `shift` (m,) [px] along their directions."""
        parts, first = [], 0
        for marks in self.marks:
            mine = (rows >= first) & (rows < first + marks.u.size)
            parts.append(_moved(marks, rows[mine] - first, shift[mine]))
            first += marks.u.size
        return replace(self, marks=tuple(parts))


def condensed(sight: Sight, residuals: Array) -> Sight:
    """One mark for each stretch of a line: its middle one, with the mean residual of the stretch instead of its own.

    `residuals` (n,) [px] of any fit that leaves out nothing but what is even along a stretch. Marks that disagree with
    the others of their stretch do not count, so no outlier is left.
    """
    rows, shifts, sigmas = [], [], []
    for line in np.unique(sight.sight_of_line):
        mine = np.flatnonzero((sight.sight_of_line == line) & np.isfinite(residuals))
        for stretch in np.array_split(mine, STRETCHES):
            if stretch.size < 2:
                continue
            aside = np.abs(residuals[stretch] - np.median(residuals[stretch]))
            kept = stretch[aside <= AGREEING * TO_DEVIATION * max(float(np.median(aside)), 1e-9)]
            middle = kept[kept.size // 2]
            rows.append(middle)
            shifts.append(residuals[kept].mean() - residuals[middle])
            sigmas.append(1 / np.sqrt(np.sum(sight.sigma[kept] ** -2.0)))
    result = sight.of(np.array(rows), np.array(shifts))
    return _with_sigma(result, np.array(sigmas))


def _moved(marks: RingMarks, rows: Whole, shift: Array) -> RingMarks:
    direction = marks.direction[rows]
    return replace(
        marks,
        u=marks.u[rows] + shift * direction[:, 0],
        v=marks.v[rows] + shift * direction[:, 1],
        direction=direction,
        sigma=marks.sigma[rows],
        ring=marks.ring[rows],
        spoke=marks.spoke[rows],
        width=None if marks.width is None else marks.width[rows],
    )


def _with_sigma(sight: Sight, sigma: Array) -> Sight:
    ends = np.cumsum([marks.u.size for marks in sight.marks])[:-1]
    parts = [replace(m, sigma=s) for m, s in zip(sight.marks, np.split(sigma, ends), strict=True)]
    return replace(sight, marks=tuple(parts))

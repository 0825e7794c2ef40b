"""The marks of all ring photographs together, line by line, and what is known of them before any fit."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rings._model import Printed
from calibore.targets import RingMarks

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

STRETCHES, FEWEST_MARKS = 24, 20
"""Into how many stretches a line is divided, of at least so many marks each. Neighbouring marks err alike: pixels and
lines meet in patterns that drift along the line. What stretches differ by holds all of that, without a model of it."""
AGREEING = 4.0
"""Robust standard deviations from the others of its stretch within which a mark counts."""
EXACT = 1e-9
"""px; less is rounding."""
FEWEST_TO_EVEN = 8.0
"""Degrees of freedom; fewer say nothing of a scatter."""
RANK = 1e-9
"""Of the largest singular value; less is rounding."""
TO_DEVIATION = 1.4826
"""Median of |x| to standard deviation of normal x."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What is `printed`, the `marks` of each picture, the image `size` (width, height) [px], the `nominal_baseline` [m]
    of the first picture; `u_ring` [m] of printed radii, None where the marks shall tell; `u_baseline` [m], None where
    it is only nominal; what is known of the camera; `enlarged` (n,): by what factor the sigma of each mark has been.
    """

    printed: Printed
    marks: tuple[RingMarks, ...]
    size: tuple[int, int]
    nominal_baseline: float
    u_ring: float | None = None
    principal_point: tuple[float, float] | None = None
    u_baseline: float | None = None
    square: bool = False
    enlarged: Array | None = None

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
    def azimuth(self) -> Array:
        """(n,) [rad] about the centre of the spokes."""
        return np.concatenate([np.arctan2(m.v - m.centre[1], m.u - m.centre[0]) for m in self.marks])

    @cached_property
    def along(self) -> Array:
        """(n,) what grows along a line: azimuth [rad] of marks on rings, distance [px] from the centre on spokes."""
        far = np.concatenate([np.hypot(m.u - m.centre[0], m.v - m.centre[1]) for m in self.marks])
        return np.where(self.on_ring, self.azimuth, far)

    @cached_property
    def on_ring(self) -> NDArray[np.bool_]:
        """(n,)"""
        return self.line <= self.printed.radii.size

    def thinned(self, most: int) -> "Sight":
        """Of the marks only every so-manieth, so that at most so many are left."""
        rows = np.arange(0, self.line.size, max(1, -(-self.line.size // most)))
        return self.of(rows, np.zeros(rows.size))

    def of(self, rows: Whole, shift: Array) -> "Sight":
        """The marks `rows` (m,) only, moved by `shift` (m,) [px] along their directions."""
        parts, first = [], 0
        for marks in self.marks:
            mine = (rows >= first) & (rows < first + marks.u.size)
            parts.append(_moved(marks, rows[mine] - first, shift[mine]))
            first += marks.u.size
        return replace(self, marks=tuple(parts))


def condensed(sight: Sight, residuals: Array, as_lines: Array) -> Sight:
    """One mark for each stretch of a line: its middle one, with the mean residual of the stretch instead of its own.

    `residuals` (n,) [px] of any fit that leaves out nothing but what is even along a stretch; `as_lines` (n,): the same
    for ink without width, which the new marks are of. Marks that disagree with others of their stretch do not count.
    """
    rows, shifts, sigmas = [], [], []
    for line in np.unique(sight.sight_of_line):
        mine = np.flatnonzero((sight.sight_of_line == line) & np.isfinite(residuals))
        mine = mine[np.argsort(sight.along[mine], kind="stable")]
        for stretch in np.array_split(mine, np.clip(mine.size // FEWEST_MARKS, 1, STRETCHES)):
            aside = np.abs(residuals[stretch] - np.median(residuals[stretch]))
            kept = stretch[aside <= AGREEING * TO_DEVIATION * np.median(aside) + EXACT]
            if kept.size:
                middle = kept[kept.size // 2]
                rows.append(middle)
                shifts.append(residuals[kept].mean() - as_lines[middle])
                sigmas.append(np.sum(sight.sigma[kept] ** -2.0) ** -0.5)
    return _with_sigma(sight.of(np.array(rows), np.array(shifts)), np.array(sigmas))


def evened(sight: Sight, residuals: Array, jacobian: Array) -> Sight:
    """The same marks with sigmas that fit their scatter, for rings and for spokes of each picture: it depends on blur,
    light, and how lines run across the pixels. `residuals` (n,) [px] of a fit and its `jacobian` (n, p) [px]; each line
    may be off as a whole.
    """
    relative, left = _scatter(sight, residuals, jacobian)
    deviation = TO_DEVIATION * float(np.median(np.abs(relative)))
    agreeing = np.abs(relative) <= AGREEING * np.sqrt(np.maximum(left, EXACT)) * deviation + EXACT
    kind, factor = 2 * sight.picture + ~sight.on_ring, np.ones(residuals.size)
    for one in np.unique(kind):
        mine = agreeing & (kind == one)
        if left[mine].sum() > FEWEST_TO_EVEN:
            factor[kind == one] = max(float(np.sqrt(np.sum(relative[mine] ** 2) / left[mine].sum())), EXACT)
    factor /= factor[0]
    return replace(_with_sigma(sight, sight.sigma * factor), enlarged=factor)


def _scatter(sight: Sight, residuals: Array, jacobian: Array) -> tuple[Array, Array]:
    """Residuals (n,) over sigma about a fit that may move each line as well, and what that fit leaves (n,) of the
    variance of each: 1 minus its leverage.
    """
    lines = sight.sight_of_line[:, None] == np.unique(sight.sight_of_line)
    size = np.linalg.norm(jacobian, axis=0)
    told = size > 0  # not what was printed of a ring outside all pictures
    table = np.column_stack([jacobian[:, told] / size[told], lines]) / sight.sigma[:, None]
    basis, strength, _ = np.linalg.svd(table, full_matrices=False)
    basis = basis[:, strength > RANK * strength[0]]
    relative = residuals / sight.sigma
    return relative - basis @ (basis.T @ relative), 1 - np.sum(basis**2, axis=1)


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

"""The wall on a regular grid about the centre, and two linear maps from standard normal numbers to walls.

`again`: what the smoother would make of the estimated wall measured anew (for the bias of extremes).
`possible`: the walls that agree with the data (for the uncertainty), the common modes and gaps among them.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from calibore.metrics._harmonics import harmonic_basis
from calibore.metrics._noise import factor, orthonormal_draws, plain_draws
from calibore.metrics._shape import RingShape
from calibore.metrics._wall import Wall

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_GRID, LARGEST_GRID = 360, 900
BRIDGED = 3.5  # clock steps: a wider hole between neighbouring points is a gap
SECOND_HARMONIC = 5  # coefficients up to it


@dataclass(frozen=True, eq=False)
class WallGrid:
    """Radii [units of the wall's scale] at `angles` (g,), the first `regular` equally spaced: `best` (g,), `freed` (g,)
    with the second harmonic not shrunk, `covered` (g,) where measured.

    again (g, d), possible (g, d'): see the module. The first `core` columns take exactly uncorrelated draws.
    centre_modes (m, 2): how the common modes move the centre; modes (m, g): what they do about the moved centre.
    edges (g, e): what not knowing where between two points an edge lies does to integrals over the turn.
    """

    angles: Array
    regular: int
    best: Array
    freed: Array
    covered: Mask
    again: Array
    possible: Array
    core: int
    modes: Array
    centre_modes: Array
    edges: Array

    @property
    def half(self) -> int:
        """Number of regular directions over half a turn."""
        return self.regular // 2

    def diameters(self, which: str) -> Array:
        """D (b, half) in the regular directions: of the "best" or "freed" wall (b = 1), of "again" or "possible"."""
        radii = self.freed if which == "freed" else self.best
        estimate = (radii[: self.half] + radii[self.half : self.regular])[None]
        return estimate if which in ("best", "freed") else estimate + self._drawn[which]

    @cached_property
    def _drawn(self) -> dict[str, Array]:
        return {"again": self._deviations(self.again), "possible": self._deviations(self.possible)}

    def _deviations(self, factors: Array) -> Array:
        factors = factors[: self.half] + factors[self.half : 2 * self.half]
        core = orthonormal_draws(self.core)
        deviations = core @ factors[:, : self.core].T
        if factors.shape[1] > self.core:
            deviations += plain_draws(len(core), factors.shape[1] - self.core) @ factors[:, self.core :].T
        return deviations


def regular_size(n: int) -> int:
    """Grid angles over the turn: where n allows, a multiple or part of n, so that turning the ring turns the grid."""
    size = n + n % 2
    while size < LEAST_GRID:
        size *= 2
    while size > LARGEST_GRID and size % 4 == 0:
        size //= 2
    return size if size <= LARGEST_GRID else LARGEST_GRID


def wall_grid(wall: Wall, ring: RingShape, *, angles: Array, regular: int) -> WallGrid:
    """`wall` at `angles` (g,) [rad about the centre], the first `regular` of them equally spaced over the turn."""
    basis = np.vstack([_regular_basis(regular, wall.harmonics), harmonic_basis(angles[regular:], wall.harmonics)])
    fit, residuals, features = wall.fit, wall.residuals, wall.features(angles)
    best, response = basis @ fit.coefficients, basis.copy()
    again, possible = [], []
    for feature in features:
        best[feature.columns] += feature.smoother @ residuals[feature.points]
        response[feature.columns] -= feature.smoother @ wall.basis[feature.points]  # there the points take over
        again.append(_placed(feature.columns, feature.smoother @ feature.noise, angles.size))
        possible.append(_placed(feature.columns, feature.spread, angles.size))
    modes, centre_modes = _modes(wall, ring, angles, best=best, regular=regular)
    covered = covered_at(angles, wall.polar.angle[wall.used])
    gap = _gap_spread(best - basis[:, :SECOND_HARMONIC] @ fit.coefficients[:SECOND_HARMONIC], covered)
    smoothed = response @ (fit.covariance @ factor(fit.precision))
    blank = np.zeros((angles.size, len(modes) + 1))
    believed = response @ factor(fit.free_covariance + np.diag(fit.doubt))
    return WallGrid(
        angles=angles,
        regular=regular,
        best=best,
        freed=best + basis[:, 3:5] @ (fit.free - fit.coefficients)[3:5],
        covered=covered,
        again=np.column_stack([smoothed, blank, *again]),
        possible=np.column_stack([believed, modes.T, gap, *possible]),
        core=smoothed.shape[1] + blank.shape[1],
        modes=modes,
        centre_modes=centre_modes,
        edges=_edges(wall, angles, regular),
    )


def covered_at(grid: Array, angles: Array) -> Mask:
    """Whether each of `grid` (g,) lies between two neighbours of `angles` closer than BRIDGED median steps."""
    angles = np.sort(angles)
    steps = np.diff(np.concatenate([angles, angles[:1] + 2 * np.pi]))
    wide = steps > BRIDGED * np.median(steps)
    before = np.searchsorted(angles, np.mod(grid, 2 * np.pi) + 1e-9, side="right") - 1
    return ~wide[before] | (np.abs(np.mod(grid, 2 * np.pi) - angles[before]) < 2e-9)


@lru_cache(maxsize=8)
def _regular_basis(size: int, harmonics: int) -> Array:
    return harmonic_basis(2 * np.pi * np.arange(size) / size, harmonics)


def _edges(wall: Wall, grid: Array, regular: int) -> Array:
    """A jump J between points dphi apart lies anywhere between them: J dphi / sqrt(12), given to the nearest angle."""
    order = np.flatnonzero(wall.used)
    angles, radii = wall.polar.angle[order], wall.polar.radius[order]
    steps = np.mod(np.roll(angles, -1) - angles, 2 * np.pi)
    jumps = np.roll(radii, -1) - radii
    sharp = wall.edges[order] & (steps < BRIDGED * np.median(steps))
    places = np.round((angles + steps / 2) * regular / (2 * np.pi)).astype(int) % regular
    edges = np.zeros((grid.size, int(sharp.sum())))
    edges[places[sharp], np.arange(edges.shape[1])] = (jumps * steps)[sharp] / np.sqrt(12) * regular / (2 * np.pi)
    return edges


def _placed(columns: NDArray[np.intp], factors: Array, size: int) -> Array:
    placed = np.zeros((size, factors.shape[1]))
    placed[columns] = factors
    return placed


def _modes(wall: Wall, ring: RingShape, grid: Array, *, best: Array, regular: int) -> tuple[Array, Array]:
    """Common modes as radii (m, g) about the centre that moves with them, and that motion (m, 2).

    A change dr along the ray of the rig changes the radius at a fixed angle by dr (cos d - r'/r sin d), d between the
    two rays; moving the centre by dc takes dc . e_r - r'/r dc . e_t away again.
    """
    if not len(ring.common_mode):
        return np.empty((0, grid.size)), np.empty((0, 2))
    steepness = _steepness(best[:regular])
    order = np.argsort(wall.polar.angle[wall.used])
    cosine, sine, angles = (a[wall.used][order] for a in (wall.polar.cosine, wall.polar.sine, wall.polar.angle))
    projection = cosine - np.interp(angles, grid[:regular], steepness, period=2 * np.pi) * sine
    along = ring.common_mode[:, wall.used][:, order] / wall.scale * projection
    modes = np.array([np.interp(grid, angles, mode, period=2 * np.pi) for mode in along])
    slope = np.interp(grid, grid[:regular], steepness, period=2 * np.pi)
    moving = np.stack([np.sin(grid) - slope * np.cos(grid), -np.cos(grid) - slope * np.sin(grid)])
    first = np.stack([np.sin(grid[:regular]), -np.cos(grid[:regular])])
    motion = np.asarray(
        np.linalg.solve(first @ moving[:, :regular].T, first @ modes[:, :regular].T), dtype=np.float64
    ).T
    return modes - motion @ moving, motion


def _steepness(radii: Array) -> Array:
    step = 2 * np.pi / radii.size
    return (np.roll(radii, -1) - np.roll(radii, 1)) / (2 * step * radii)


def _gap_spread(beyond: Array, covered: Mask) -> Array:
    """Extra standard uncertainty (g,) in gaps: the wall may do there what it does elsewhere `beyond` an ellipse.

    One draw for all gaps: nothing says that what hides in two of them cancels.
    """
    return np.where(covered, 0.0, np.sqrt(np.mean(beyond[covered] ** 2)))

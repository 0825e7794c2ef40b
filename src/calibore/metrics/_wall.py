"""The wall estimated from one ring: its centre, its shape about that centre, and what is not known of both.

Radii are referred to the centre point by point: an off-centre rig moves them in angle as well as in length.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import clock_of, fit_circle, xy_of
from calibore.metrics._centre import robust_centre, spread
from calibore.metrics._features import Feature, feature_between, lone_points, sharp_jumps, split_runs, stretches
from calibore.metrics._harmonics import HarmonicFit, fit_harmonics, harmonic_basis, harmonic_count, harmonic_slope
from calibore.metrics._noise import Noise
from calibore.metrics._shape import RingShape

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

START_HARMONICS = 6
START_ROUNDS = 4
START_RIDGE = 1e-3  # harmonics that a missing arc leaves open stay small
CAUCHY = 2.5
PASSES = 5
LEAST_SIGMA = 1e-6  # of the radius: exact radii must not divide by zero
LEAST_PROJECTION = 0.2
LEAST_RADIUS = 0.1
FEWEST_PAIRS = 20
FEWEST_PLAIN, LEAST_PLAIN = 12, 0.2  # points, and share of points, outside features
EXCESS_NOISE = 1.4  # of the stated; the median of 400 differences is good to 5 %, less if correlated


@dataclass(frozen=True, eq=False)
class Polar:
    """The points about a centre: angle (n,) and radius (n,), 0 where missing, in units of the scale.

    cosine, sine (n,): of the angle between the ray of the rig and the ray from the centre.
    """

    angle: Array
    radius: Array
    cosine: Array
    sine: Array


@dataclass(frozen=True, eq=False)
class Wall:
    """Lengths in units of `scale` [m]. The smooth series is `fit` on `basis` (n, p).

    `used` (n,): points that count; those in `features_mask` (n,) stand off the series.
    `excess_noise`: how much more noise there is than stated, 1 if not clearly more.
    """

    scale: float
    centre: Array
    polar: Polar
    basis: Array
    fit: HarmonicFit
    noise: Noise
    features_mask: Mask
    used: Mask
    excess_noise: float

    @property
    def residuals(self) -> Array:
        return self.polar.radius - self.basis @ self.fit.coefficients

    @property
    def harmonics(self) -> int:
        return self.fit.coefficients.size // 2

    @property
    def edges(self) -> Mask:
        """Shape (n,): an edge lies between this point and the next measured one."""
        order = np.flatnonzero(self.used)
        edges = np.zeros(self.used.size, dtype=bool)
        edges[order] = sharp_jumps(self.polar.radius[order], self.noise.sigma[order])
        return edges

    def features(self, grid: Array) -> list[Feature]:
        """The features with the columns of `grid` (g,) [rad] that belong to them: to half a step beyond their ends."""
        residuals, angle, found = self.residuals, self.polar.angle, []
        step = 2 * np.pi / angle.size
        for points in split_runs(self.features_mask, self.edges) if self.features_mask.any() else []:
            first, last = points[0], points[-1]
            before, after = (first - 1) % angle.size, (last + 1) % angle.size
            start = angle[first] - (np.mod(angle[first] - angle[before], 2 * np.pi) if self.used[before] else step) / 2
            stop = angle[last] + (np.mod(angle[after] - angle[last], 2 * np.pi) if self.used[after] else step) / 2
            extent = np.mod(stop - start, 2 * np.pi) if points.size < angle.size else np.inf
            columns = np.flatnonzero(np.mod(grid - start, 2 * np.pi) < extent)
            found.append(
                feature_between(points, columns, angles=angle, grid=grid, residuals=residuals, noise=self.noise)
            )
        return found


@dataclass(frozen=True, eq=False)
class _Stated:
    """What does not change from pass to pass: the ring, its scale [m], its stated noise in units of the scale."""

    ring: RingShape
    scale: float
    sigma: Array

    def about(self, centre: Array) -> Polar:
        """The points about `centre` (2,)."""
        ring = self.ring
        x, y = xy_of(ring.clock, np.where(ring.measured, ring.radius, 0.0) / self.scale)
        x, y = x - centre[0], y - centre[1]
        angle = clock_of(x, y)
        turn = ring.clock - angle
        return Polar(angle, np.where(ring.measured, np.hypot(x, y), 0.0), np.cos(turn), np.sin(turn))


@dataclass(frozen=True, eq=False)
class _Guess:
    """What a pass starts from and the next one improves."""

    centre: Array
    used: Mask
    featured: Mask
    slope: Array
    excess: float | None = None
    prior: Array | None = None


def estimate_wall(ring: RingShape) -> Wall:
    """The wall of a ring with at least 8 measured points; passes of fitting, centring and finding features."""
    used = ring.measured
    points = np.column_stack(xy_of(ring.clock[used], ring.radius[used]))
    circle = fit_circle(points, robust=True)
    scale = circle.radius
    sigma = np.maximum(np.where(used, ring.u_independent, 0.0) / scale, LEAST_SIGMA)
    stated = _Stated(ring, scale, sigma)
    guess = _robust_start(stated, robust_centre(points / scale, sigma[used], start=circle.centre / scale))
    wall, better = _pass(stated, guess)
    for _ in range(PASSES - 1):
        same = (better.featured == guess.featured).all() and (better.used == guess.used).all()
        if guess.prior is not None and same:
            break
        guess = better
        wall, better = _pass(stated, guess)
    return wall


def _pass(stated: _Stated, guess: _Guess) -> tuple[Wall, _Guess]:
    """The wall fitted with what `guess` believes of centre and features, and the better guess it leads to."""
    polar, plain = stated.about(guess.centre), guess.used & ~guess.featured
    if plain.sum() < max(FEWEST_PLAIN, LEAST_PLAIN * guess.used.sum()):
        plain = guess.used  # no smooth wall to speak of: a series through all, features do the rest
    basis = harmonic_basis(polar.angle, harmonic_count(int(plain.sum())))
    projection = np.maximum(np.abs(polar.cosine - guess.slope * polar.sine), LEAST_PROJECTION)
    noise = Noise(
        np.where(stated.ring.measured, stated.sigma * projection * (guess.excess or 1.0), 0.0), stated.ring.correlation
    )
    weights = np.zeros(plain.size)
    weights[plain] = noise.sigma[plain] ** -2.0
    prior = guess.prior if guess.prior is not None and guess.prior.size == basis.shape[1] else None
    fit = fit_harmonics(basis, polar.radius, weights=weights, noise=noise, prior=prior)
    smooth = basis @ fit.coefficients
    off = np.where(guess.used, polar.radius - smooth, 0.0) / np.where(guess.used, noise.sigma, 1.0)
    excess = guess.excess or _excess(off, plain, noise.correlation)
    off = off * (guess.excess or 1.0) / excess
    used = guess.used & ~lone_points(off, guess.used)
    wall = Wall(stated.scale, guess.centre, polar, basis, fit, noise, guess.featured, guess.used, excess)
    slope = harmonic_slope(basis, fit.coefficients) / np.maximum(smooth, LEAST_RADIUS)
    return wall, _Guess(guess.centre, used, stretches(off, used, noise), slope, excess, fit.prior)


def _robust_start(stated: _Stated, centre: Array) -> _Guess:
    """A low series about `centre` fitted with weights that let features go."""
    used, polar = stated.ring.measured, stated.about(centre)
    basis = harmonic_basis(polar.angle, min(START_HARMONICS, harmonic_count(int(used.sum()))))
    weights, ridge = used.astype(float), np.diag(np.r_[0.0, 0.0, 0.0, np.full(basis.shape[1] - 3, START_RIDGE)])
    coefficients, off = np.zeros(basis.shape[1]), np.zeros(used.size)
    for _ in range(START_ROUNDS):
        weighted = basis.T * weights
        coefficients = np.linalg.solve(weighted @ basis + used.sum() * ridge, weighted @ polar.radius)
        off = np.where(used, polar.radius - basis @ coefficients, 0.0)
        scatter = spread(off[used]) + LEAST_SIGMA
        weights = np.where(used, (1 + (off / (CAUCHY * scatter)) ** 2) ** -2.0, 0.0)
    off = off / stated.sigma
    featured = stretches(off / max(1.0, spread(off[used])), used, Noise(stated.sigma, stated.ring.correlation))
    return _Guess(centre, used, featured, np.zeros(used.size))


def _excess(off: Array, plain: Mask, correlation: Array) -> float:
    """How far the differences of neighbours exceed the stated noise; 1 where they do not exceed it clearly."""
    pairs = plain & np.roll(plain, -1)
    if pairs.sum() < FEWEST_PAIRS:
        return 1.0
    expected = np.sqrt(2 * max(1 - (correlation[0] if correlation.size else 0.0), 0.05))
    excess = spread((np.roll(off, -1) - off)[pairs]) / expected
    return excess if excess > EXCESS_NOISE else 1.0

"""The smooth part of the wall: a Fourier series whose every harmonic has to earn its place.

r(phi) = sum of a_k cos(k phi) + b_k sin(k phi). The mean and the first harmonic are free. Each higher harmonic is
either absent or present with an amplitude scale of its own ("spike and slab"); the estimate is the average over both,
weighted by evidence (marginal likelihood) at the known noise. On a round pipe nearly nothing is left of the noise; an
ellipse well above the noise is kept whole. Each harmonic is judged given the others, so missing arcs, where harmonics
cannot be told apart, do not make the series swing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.metrics._noise import Noise, inverse

Array = NDArray[np.float64]

HARMONICS = 16
POINTS_PER_HARMONIC = 4
PRIOR_ODDS = 0.15  # of ovality being present: keeps the false ovality of a round pipe well below its u
ODDS_DECAY = 2.0  # power of 2 / k: pipes bend in low harmonics
SMALLEST_SLAB = 3.0  # amplitude variance of a present harmonic over its noise variance, at least
LARGEST_EVIDENCE = 500.0  # exp() beyond overflows; the harmonic is certain long before
ROUNDS, FURTHER_ROUNDS = 4, 2
LEAST_KEPT = 1e-4
SMALLEST_VARIANCE = 1e-30
LEAST_PRIOR = 1e-10  # of the largest precision: rounding
RIDGE = 1e-9  # relative: a short arc must not divide by zero
WIDE_PRIOR = 0.05  # of the radius: start of the iteration


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """Coefficients (p,) [1, cos, sin, cos 2, ...], what the data say about them and what was believed.

    precision (p, p): of the data alone; prior (p,): of the belief; covariance (p, p): inverse of their sum;
    doubt (p,): further variance from not knowing which harmonics are present.
    free (p,), free_covariance (p, p): the same with nothing believed of the second harmonic, which ovality rests on.
    """

    coefficients: Array
    precision: Array
    prior: Array
    covariance: Array
    doubt: Array
    free: Array
    free_covariance: Array


def harmonic_count(points: int) -> int:
    return min(HARMONICS, max(2, (points // POINTS_PER_HARMONIC - 1) // 2))


def harmonic_basis(angles: Array, harmonics: int) -> Array:
    """Columns (n, 2 harmonics + 1): 1, cos, sin, cos 2, sin 2, ..."""
    basis = np.empty((angles.size, 2 * harmonics + 1), order="F")
    basis[:, 0] = 1.0
    turn = np.cos(angles) + 1j * np.sin(angles)
    power = np.ones_like(turn)
    for k in range(1, harmonics + 1):
        power = power * turn
        basis[:, 2 * k - 1], basis[:, 2 * k] = np.real(power), np.imag(power)
    return basis


def harmonic_slope(basis: Array, coefficients: Array) -> Array:
    """dr/dphi (n,) at the angles of `basis`."""
    order = np.arange(1, coefficients.size // 2 + 1)
    slope = np.zeros_like(coefficients)
    slope[1::2], slope[2::2] = order * coefficients[2::2], -order * coefficients[1::2]
    return basis @ slope


def fit_harmonics(
    basis: Array, radii: Array, *, weights: Array, noise: Noise, prior: Array | None = None
) -> HarmonicFit:
    """The series through `radii` (n,) [in units of the radius]; `weights` (n,) = 1 / u^2, zero where not used."""
    weighted = basis * weights[:, None]
    precision, score = weighted.T @ basis, weighted.T @ radii
    if noise.correlation.size:
        spread = noise.covariance_of(weighted)
        spread[np.diag_indices_from(spread)] *= 1 + RIDGE
        whitened = np.linalg.solve(spread, precision)
        precision, score = precision @ whitened, whitened.T @ score
        precision = 0.5 * (precision + precision.T)
    rounds = ROUNDS if prior is None else FURTHER_ROUNDS
    if prior is None:
        prior = np.concatenate([np.zeros(3), np.full(basis.shape[1] - 3, WIDE_PRIOR**-2)])
    doubt: Array = np.zeros_like(prior)
    least = np.where(prior > 0, LEAST_PRIOR * float(np.max(np.diag(precision))), 0.0)
    for _ in range(rounds):
        prior = np.maximum(prior, least)
        covariance = inverse(precision + np.diag(prior))
        prior, doubt = _judged(covariance, covariance @ score, prior)
    covariance = inverse(precision + np.diag(prior))
    without = prior.copy()
    without[3:5] = doubt[3:5] = 0.0
    free = inverse(precision + np.diag(without))
    return HarmonicFit(covariance @ score, precision, prior, covariance, doubt, free @ score, free)


def _judged(covariance: Array, coefficients: Array, prior: Array) -> tuple[Array, Array]:
    """New prior precision and doubt (p,) from the evidence of every harmonic given the others.

    With c, s the estimate and precision of a pair without its own prior, E = c^T s c / 2 and slab-to-noise ratio g:
    evidence of presence B = exp(E g / (1 + g)) / (1 + g), weight w = B odds / (1 + B odds). Kept is
    w sqrt(g / (1 + g)), which takes the noise power out of the amplitude (Rice); w g / (1 + g) would take too much.
    """
    even, odd = slice(3, None, 2), slice(4, None, 2)
    diagonal = np.diag(covariance)
    p, q, cross = diagonal[even], diagonal[odd], np.diag(covariance, 1)[3::2]
    p, q = np.maximum(p, SMALLEST_VARIANCE), np.maximum(q, SMALLEST_VARIANCE)
    determinant = np.maximum(p * q - cross * cross, RIDGE * p * q)
    own = prior[even]
    s11, s22, s12 = q / determinant - own, p / determinant - own, -cross / determinant
    a, b = coefficients[even], coefficients[odd]
    h1, h2 = (q * a - cross * b) / determinant, (p * b - cross * a) / determinant
    scale = np.maximum(0.5 * (s11 + s22), 1e-12)
    inner = np.maximum(s11 * s22 - s12 * s12, 1e-3 * scale * scale)
    energy = np.maximum(0.5 * (s22 * h1 * h1 - 2 * s12 * h1 * h2 + s11 * h2 * h2) / inner, 0.0)
    ratio = np.maximum(energy - 1, SMALLEST_SLAB)
    shrink = ratio / (1 + ratio)
    odds = PRIOR_ODDS * (2 / np.arange(2, energy.size + 2)) ** ODDS_DECAY
    bayes = odds * np.exp(np.minimum(energy * shrink, LARGEST_EVIDENCE)) / (1 + ratio)
    present = bayes / (1 + bayes)
    shrink = np.sqrt(shrink)
    kept = np.maximum(present * shrink, LEAST_KEPT)
    new_prior, doubt = np.zeros_like(prior), np.zeros_like(prior)
    new_prior[even] = new_prior[odd] = scale * (1 / kept - 1)
    doubt[even] = doubt[odd] = present * (1 - present) * shrink**2 * energy / scale
    return new_prior, doubt

"""Propagation of distributions: the adaptive Monte Carlo procedure (JCGM 101, 7.9; JCGM 102, 7.8)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.uncertainty import _intervals as intervals
from calibore.uncertainty._checks import indices
from calibore.uncertainty._covariance import Covariance
from calibore.uncertainty._coverage import PROBABILITY, check_probability

Array = NDArray[np.float64]
Model = Callable[[Array], ArrayLike]

BLOCK = 10_000  # JCGM 101, 7.9.4 b
TAIL_DRAWS = 100  # outside the interval, in each block (JCGM 101, 7.9.4 b)
LEAST_BLOCKS = 5  # the standard's two agree by chance too often
MOST_DRAWS = 2_000_000
KEPT_DRAWS = 1_000_000  # for shortest intervals and regions; more blocks count in all other numbers
LEFTOVER = 2  # values without which there is no standard deviation


@dataclass(frozen=True, eq=False)
class MonteCarloResult:
    """Of q outputs: `mean`, `u` (q,), `covariance` (q, q); intervals (q, 2), one row per output, and 95 % regions.

    `ellipsoid_factor` k: (y - mean)' covariance^-1 (y - mean) <= k^2; `rectangle` (q, 2) holds all outputs at once.
    `draws` were made; of them the fraction `lost` had no result (not finite) and is left out of everything.
    `settled`: twice the standard deviation of every number is below its `tolerance` (q,), that is u to `digits`.
    `shortfall` of correlations: see `Scores`.
    """

    mean: Array
    u: Array
    covariance: Array
    symmetric: Array
    shortest: Array
    ellipsoid_factor: float
    rectangle: Array
    probability: float
    draws: int
    lost: float
    settled: bool
    tolerance: Array
    shortfall: float


def monte_carlo(
    model: Model,
    estimates: ArrayLike,
    covariance: Covariance,
    *,
    rng: np.random.Generator,
    names: Sequence[str] | None = None,
    probability: float = PROBABILITY,
    digits: int = 2,
    most_draws: int = MOST_DRAWS,
) -> MonteCarloResult:
    """Draws inputs (m, p), asks `model` for outputs (m,) or (m, q), until u is known to `digits` significant digits.

    `names` are those of the `estimates` (p,), by default the covariance's; what it does not name is exactly known.
    Outputs that are not finite are lost draws, not errors. Stops unsettled at `most_draws`.
    """
    check_probability(probability)
    if digits < 1:
        raise InputError(f"An uncertainty has at least one significant digit, got {digits}; give 1 or 2.")
    block = max(BLOCK, ceil(TAIL_DRAWS / (1 - probability)))
    if most_draws < block:
        raise InputError(f"One block of draws needs {block}, got most_draws = {most_draws}; allow more.")
    source = _Draws(model, _estimates(estimates, covariance, names), covariance, rng, names or covariance.names)
    tally = _Tally(probability, digits)
    for values in source.blocks(block, most_draws):
        tally.add(values)
        if tally.settled():
            break
    return tally.result(source)


class _Draws:
    """Outputs in blocks of equal size; what is not finite is counted and left out."""

    def __init__(
        self, model: Model, estimates: Array, covariance: Covariance, rng: np.random.Generator, names: Sequence[str]
    ) -> None:
        self.model, self.estimates, self.covariance, self.rng = model, estimates, covariance, rng
        self.columns = indices(covariance.names, names)
        self.made = self.lost = 0

    def outputs(self, n: int) -> Array:
        inputs = np.tile(self.estimates, (n, 1))
        inputs[:, self.columns] += self.covariance.draw(self.rng, n)
        values = np.asarray(self.model(inputs), dtype=float)
        if values.ndim not in (1, 2) or len(values) != n:
            raise InputError(
                f"The model gave shape {values.shape} for {n} draws; it must give ({n},) or ({n}, outputs)."
            )
        values = values.reshape(n, -1)
        here = np.isfinite(values).all(axis=1)
        self.made, self.lost = self.made + n, self.lost + int(n - here.sum())
        return values[here]

    def blocks(self, size: int, most: int) -> Iterator[Array]:
        """Blocks of `size` values each; one smaller block where `most` draws do not fill a single one."""
        waiting, complete = self.outputs(size), 0
        while True:
            if len(waiting) >= size:
                complete += 1
                yield waiting[:size]
                waiting = waiting[size:]
            elif self.made + size <= most:
                waiting = np.concatenate([waiting, self.outputs(size)])
            else:
                break
        if not complete:
            yield waiting


class _Tally:
    """Running sums about the first block's mean, what each block says, and the first values."""

    def __init__(self, probability: float, digits: int) -> None:
        self.probability, self.digits = probability, digits
        self.of_blocks: list[Array] = []
        self.kept: list[Array] = []
        self.count = 0

    def add(self, values: Array) -> None:
        if not self.of_blocks:
            q = values.shape[1]
            self.origin = values.mean(axis=0) if len(values) else np.zeros(q)
            self.sum, self.products = np.zeros(q), np.zeros((q, q))
        if self.count < KEPT_DRAWS:
            self.kept.append(values)
        away = values - self.origin
        self.count += len(values)
        self.sum += away.sum(axis=0)
        self.products += away.T @ away
        self.of_blocks.append(self._says(values))

    def _says(self, values: Array) -> Array:
        """Of one block: mean, u, low and high end of every output, and k of the ellipsoid if there are several."""
        if len(values) < LEFTOVER:
            return np.full(4 * values.shape[1], np.nan)
        mean, u = values.mean(axis=0), values.std(axis=0, ddof=1)
        numbers = [mean, u, *intervals.symmetric_interval(values, self.probability)]
        if values.shape[1] > 1:
            covariance = np.cov(values, rowvar=False)
            numbers.append(
                np.array([intervals.ellipsoid_factor(values, mean, covariance, probability=self.probability)])
            )
        return np.concatenate(numbers)

    def moments(self) -> tuple[Array, Array]:
        """Mean (q,) and covariance (q, q) of all values."""
        if self.count < LEFTOVER:
            return np.full_like(self.sum, np.nan), np.full_like(self.products, np.nan)
        away = self.sum / self.count
        covariance = (self.products - self.count * np.outer(away, away)) / (self.count - 1)
        return self.origin + away, covariance

    def tolerance(self) -> Array:
        """Half a unit in the last of `digits` digits of u (q,) (JCGM 101, 7.9.2)."""
        return tolerance_of(np.sqrt(np.maximum(np.diag(self.moments()[1]), 0.0)), self.digits)

    def settled(self) -> bool:
        """Whether the averages over blocks scatter less than the tolerance (JCGM 101, 7.9.4)."""
        if len(self.of_blocks) < LEAST_BLOCKS:
            return False
        blocks, tolerance = np.stack(self.of_blocks), np.tile(self.tolerance(), 4)
        if blocks.shape[1] > tolerance.size:
            tolerance = np.append(tolerance, tolerance_of(blocks[:, -1:].mean(axis=0), self.digits))
        scatter = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
        return bool((2 * scatter <= tolerance).all())

    def result(self, source: _Draws) -> MonteCarloResult:
        mean, covariance = self.moments()
        u, q, values = np.sqrt(np.maximum(np.diag(covariance), 0.0)), len(mean), np.concatenate(self.kept)
        low, high = np.stack(self.of_blocks).mean(axis=0)[2 * q : 4 * q].reshape(2, q)
        enough = len(values) * (1 - self.probability) >= 1
        shortest, k_ellipsoid, k_rectangle = np.full((2, q), np.nan), np.nan, np.nan
        if enough:
            shortest = intervals.shortest_interval(values, self.probability)
            k_ellipsoid = intervals.ellipsoid_factor(values, mean, covariance, probability=self.probability)
            k_rectangle = intervals.rectangle_factor(values, mean, u, probability=self.probability)
        return MonteCarloResult(
            mean=mean,
            u=u,
            covariance=covariance,
            symmetric=np.stack([low, high], axis=1),
            shortest=shortest.T,
            ellipsoid_factor=k_ellipsoid,
            rectangle=np.stack([mean - k_rectangle * u, mean + k_rectangle * u], axis=1),
            probability=self.probability,
            draws=source.made,
            lost=source.lost / source.made,
            settled=self.settled(),
            tolerance=self.tolerance(),
            shortfall=source.covariance.scores.shortfall,
        )


def tolerance_of(numbers: Array, digits: int) -> Array:
    """Half a unit in the last of `digits` significant digits of `numbers` (JCGM 101, 7.9.2)."""
    size = np.abs(numbers)
    with np.errstate(divide="ignore"):
        place = np.floor(np.log10(size)) - digits + 1
    return np.where(size > 0, 0.5 * 10.0**place, 0.0)


def _estimates(given: ArrayLike, covariance: Covariance, names: Sequence[str] | None) -> Array:
    estimates, expected = np.asarray(given, dtype=float), len(names or covariance.names)
    if estimates.shape != (expected,):
        raise InputError(
            f"{expected} inputs need as many estimates, got shape {estimates.shape}; give one number each."
        )
    if not np.isfinite(estimates).all():
        raise InputError("Estimates must be finite, got NaN or infinity; a point that does not exist cannot be drawn.")
    return estimates

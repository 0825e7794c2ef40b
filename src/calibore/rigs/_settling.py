"""Monte Carlo until it has settled: the adaptive procedure of JCGM 101, 7.9, for many wall points at once."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.rigs._drawing import PROBABILITY, Drawn, DrawnQuantity, monte_carlo
from calibore.rigs._rig import Rig
from calibore.uncertainty import tolerance_of

Array = NDArray[np.float64]
BLOCK = 10_000
"""Draws between two looks at what has settled (JCGM 101, 7.9.4)."""
LEAST_BLOCKS = 5
"""Two blocks may agree by chance."""
MOST_DRAWS = 2_000_000
AVERAGED = ("mean", "u", "median", "symmetric", "shortest")


@dataclass(frozen=True, eq=False)
class Settled:
    """`drawn`: all blocks together, intervals and median averaged over them. `settled` (n,): whether mean, u and the
    symmetric interval of radius and axial are known to half a unit of the last asked digit of u.
    """

    drawn: Drawn
    settled: NDArray[np.bool_]


def adaptive_monte_carlo(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    u_pixel: ArrayLike,
    rng: np.random.Generator,
    digits: int = 2,
    most_draws: int = MOST_DRAWS,
    probability: float = PROBABILITY,
    **options: Any,
) -> Settled:
    """`monte_carlo` in blocks until every point's u is known to `digits` significant digits, or `most_draws` are made.

    `options` are those of `monte_carlo`. Points that lose nearly all draws have NaN and never settle.
    """
    if digits < 1:
        raise InputError(f"An uncertainty has at least one significant digit, got {digits}; give 1 or 2.")
    draw = {"u_pixel": u_pixel, "draws": BLOCK, "rng": rng, "probability": probability, **options}
    blocks = [monte_carlo(rig, u, v, **draw)]
    while not _settled(blocks, digits).all() and (len(blocks) + 1) * BLOCK <= most_draws:
        blocks.append(monte_carlo(rig, u, v, **draw))
    return Settled(_together(blocks), _settled(blocks, digits))


def _settled(blocks: list[Drawn], digits: int) -> NDArray[np.bool_]:
    """(n,) whether averages over blocks scatter less than half a unit of the last digit of u."""
    if len(blocks) < LEAST_BLOCKS:
        return np.zeros(blocks[0].lost.shape, dtype=bool)
    done = np.ones(blocks[0].lost.shape, dtype=bool)
    for quantity in (lambda one: one.radius, lambda one: one.axial):
        says = np.stack([_numbers(quantity(one)) for one in blocks])
        scatter = 2 * says.std(axis=0, ddof=1) / np.sqrt(len(blocks))
        done &= (scatter <= tolerance_of(says[:, 1].mean(axis=0), digits)).all(axis=0)
    return done


def _numbers(one: DrawnQuantity) -> Array:
    """(4, n): mean, u, both ends of the symmetric interval."""
    return np.stack([one.mean, one.u, *one.symmetric.T])


def _together(blocks: list[Drawn]) -> Drawn:
    """All blocks as one: moments pooled by the draws that were not lost, the rest averaged."""
    count = np.stack([(1 - one.lost) * one.draws for one in blocks])
    total = count.sum(axis=0)
    last = blocks[-1]

    def pooled(of: Callable[[Drawn], DrawnQuantity]) -> DrawnQuantity:
        mean, variance = _pooled(count, *(np.stack([getattr(of(one), key) for one in blocks]) for key in ("mean", "u")))
        rest = {key: np.mean([getattr(of(one), key) for one in blocks], axis=0) for key in AVERAGED[2:]}
        return DrawnQuantity(mean, np.sqrt(variance), **rest)

    radius, axial = pooled(lambda one: one.radius), pooled(lambda one: one.axial)
    within = np.sum([n * one.covariance for n, one in zip(count, blocks, strict=True)], axis=0)
    away = [(one.radius.mean - radius.mean) * (one.axial.mean - axial.mean) for one in blocks]
    with np.errstate(invalid="ignore"):  # every draw lost
        covariance = (within + np.sum(count * away, axis=0)) / total
    lost, draws = np.mean([one.lost for one in blocks], axis=0), sum(one.draws for one in blocks)
    none = np.empty((lost.size, 0))
    return Drawn(radius, axial, covariance, lost, last.branch, draws, last.probability, none, none)


def _pooled(count: Array, means: Array, spreads: Array) -> tuple[Array, Array]:
    """Mean and variance (n,) of all draws from those of the blocks (b, n)."""
    with np.errstate(invalid="ignore"):  # every draw lost
        mean = np.sum(count * means, axis=0) / count.sum(axis=0)
        within = np.sum((count - 1) * spreads**2 + count * (means - mean) ** 2, axis=0)
        return mean, within / (count.sum(axis=0) - 1)

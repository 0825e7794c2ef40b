"""Which parameters the data tell apart, and which they do not."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._fit import Fit
from calibore.fitting._rank import DETERMINED, Spectrum, spectrum

Array = NDArray[np.float64]

CONFUSED = 0.99
"""Correlation above which two parameters are reported as hard to tell apart."""
MENTIONED = 0.05
"""Share of the weakest direction below which a parameter is not named."""


@dataclass(frozen=True, eq=False)
class Identifiability:
    """`rank` of the whitened Jacobian with prior, its columns scaled to length 1, and its `singular_values` (p,).

    `weakest`: the combination that the data determine least, as shares of 1 (those below 5 % left out), largest
    first; `weakest_change`: how much each of them changes along it, relative to its value where that is not 0, the
    largest by 0.01. `pairs`: (name, name, correlation) beyond 0.99, the worst first; by them `str` says it to people.
    """

    names: tuple[str, ...]
    rank: int
    singular_values: Array
    weakest: Mapping[str, float]
    weakest_change: Mapping[str, float]
    pairs: tuple[tuple[str, str, float], ...]

    @property
    def complete(self) -> bool:
        return self.rank == len(self.names)

    def __str__(self) -> str:
        together = " and ".join(self.weakest)
        if not self.complete:
            changes = ", ".join(f"{name} {100 * change:+.3g} %" for name, change in self.weakest_change.items())
            told = f"The data determine {self.rank} combinations of {len(self.names)} parameters"
            return f"{told}: {together} can change together without changing any datum ({changes})."
        if self.pairs:
            first, second, correlation = self.pairs[0]
            return f"{first} and {second} cannot be told apart well (correlation {correlation:.4f})."
        return f"The data tell all {len(self.names)} parameters apart; least well {together}."


def identifiability(fit: Fit) -> Identifiability:
    """What the data of `fit` and its prior determine; works where they determine too little."""
    if fit.information_root is None:
        raise ValueError("Identifiability needs a fit of least_squares.")
    found = spectrum(fit.information_root)
    direction = found.axes[-1]
    order = np.argsort(-(direction**2), kind="stable")
    named = [i for i in order if direction[i] ** 2 >= MENTIONED]
    change = direction / found.scale
    change = change / np.where(fit.values != 0, np.abs(fit.values), 1.0)
    largest = change[named[np.argmax(np.abs(change[named]))]]
    return Identifiability(
        names=fit.names,
        rank=found.rank,
        singular_values=found.values,
        weakest={fit.names[i]: float(direction[i] ** 2) for i in named},
        weakest_change={fit.names[i]: float(change[i] / largest) / 100 for i in named},
        pairs=_pairs(fit.names, _correlation(fit, found)),
    )


def _correlation(fit: Fit, found: Spectrum) -> Array:
    """Correlation (p, p); undetermined directions count as very badly determined ones."""
    covariance = fit.covariance
    if not np.isfinite(covariance).all():
        floor = DETERMINED / 100 * found.values[0]
        factor = found.axes.T / np.maximum(found.values, floor) / found.scale[:, None]
        covariance = factor @ factor.T
    scale = np.sqrt(np.diag(covariance))
    scale = np.where(scale > 0, scale, 1.0)
    return covariance / np.outer(scale, scale)


def _pairs(names: tuple[str, ...], correlation: Array) -> tuple[tuple[str, str, float], ...]:
    rows, columns = np.nonzero(np.triu(np.abs(correlation) > CONFUSED, 1))
    found = [(names[i], names[j], float(correlation[i, j])) for i, j in zip(rows, columns, strict=True)]
    return tuple(sorted(found, key=lambda pair: -abs(pair[2])))

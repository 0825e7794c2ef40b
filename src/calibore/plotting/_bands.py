"""Errors in bands of the radius: what is predicted to hold 95 % of a band's points, and what does."""

from typing import NamedTuple

import numpy as np
from scipy.special import erf

from calibore.plotting._stations import Floats

FEWEST = 12
"""Points that a band must hold."""
HELD = 0.95
HALVINGS = 40


class Bands(NamedTuple):
    """`edges` (k + 1,) of k bands, half widths `predicted` and `observed` (k,); NaN where a band has too few points."""

    edges: Floats
    predicted: Floats
    observed: Floats


def bands_of(radius: Floats, value: Floats, u: Floats, *, count: int) -> Bands:
    """Of errors `value` (p,) at a `radius` (p,), each with its own standard uncertainty `u` (p,)."""
    edges = np.linspace(radius.min() - 1e-9, radius.max() + 1e-9, count + 1)
    band = np.clip(np.searchsorted(edges, radius, side="right") - 1, 0, count - 1)
    predicted, observed = np.full(count, np.nan), np.full(count, np.nan)
    for number in range(count):
        some = band == number
        if np.count_nonzero(some) >= FEWEST:
            predicted[number] = holding(u[some])
            observed[number] = np.quantile(np.abs(value[some]), HELD)
    return Bands(edges, predicted, observed)


def holding(u: Floats) -> float:
    """Half width that holds 95 % of normal errors of which each has its own standard deviation in `u` (p,)."""
    u = np.maximum(u, 1e-300)
    low, high = 0.0, 2.0 * float(u.max())
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        enough = float(np.mean(erf(middle / (np.sqrt(2) * u)))) >= HELD
        low, high = (low, middle) if enough else (middle, high)
    return high

"""The intercept from diameters in the pipe, and whether they agree (Swanbom 2007, eq. 8-1, corrected)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OUTLYING = 4.0
"""Standard deviations from the others at which a diameter is left out, if two others at least agree."""
CALM, FEW = 0.001, 3
"""Up to so many others must agree among themselves, by chance at least as often as this."""
DOUBTFUL = 0.01
"""Diameters that disagree by chance less often than this enlarge their uncertainty."""


@dataclass(frozen=True, eq=False)
class Intercept:
    """`value` [m], the `each` (m,) [m] of its diameters, their standard uncertainties `u_each` (m,) [m] apart from the
    slope's, those `kept` (m,); `u` [m] of the value apart from the slope's, with `freedom`; `mean_ratio`: by how much
    it falls per slope. `enlarged`: factor by which disagreement raised u; `deviation` (m,): of each from the others, in
    standard uncertainties.
    """

    value: float
    each: Array
    u_each: Array
    kept: NDArray[np.bool_]
    u: float
    freedom: float
    mean_ratio: float
    enlarged: float
    deviation: Array


def intercepts(slope: float, raw: Array, diameter: Array, *, u_diameter: Array, freedom: float) -> Intercept:
    """From ratios `raw` (m, 2) at opposite stops and `diameter` (m,) [m]: b = [diameter - slope (raw1 + raw2)] / 2,
    the printed form of 8-1 has no dimension. `u_diameter` (m,) [m] of diameter minus slope times ratios, known with
    `freedom`.
    """
    each, u_each = (diameter - slope * raw.sum(axis=1)) / 2, u_diameter / 2
    kept = np.ones(each.size, dtype=bool)
    while (worst := _outlier(each, u_each, kept)) is not None:
        kept[worst] = False
    weight = np.where(kept, u_each**-2.0, 0.0)
    weight /= weight.sum()
    value = float(weight @ each)
    spare = int(kept.sum()) - 1
    chi_square = float(np.sum(((each - value) / u_each)[kept] ** 2))
    u = float(np.sum(weight**2 * u_each**2) ** 0.5)
    enlarged = 1.0
    if spare and _by_chance(chi_square, spare) < DOUBTFUL:
        enlarged, freedom = float(np.sqrt(chi_square / spare)), spare
    return Intercept(
        value=value,
        each=each,
        u_each=u_each,
        kept=kept,
        u=u * enlarged,
        freedom=freedom,
        mean_ratio=float(weight @ raw.sum(axis=1)) / 2,
        enlarged=enlarged,
        deviation=_from_others(each, u_each, kept),
    )


def _outlier(each: Array, u: Array, kept: NDArray[np.bool_]) -> int | None:
    """The diameter furthest from the others, if it is off and at least two others are left that agree."""
    if kept.sum() < 3:
        return None
    off = np.where(kept, np.abs(_from_others(each, u, kept)), 0.0)
    worst = int(np.argmax(off))
    others = kept & (np.arange(each.size) != worst)
    mean = np.average(each[others], weights=u[others] ** -2)
    calm = _by_chance(float(np.sum(((each - mean) / u)[others] ** 2)), int(others.sum()) - 1)
    return worst if off[worst] > OUTLYING and (calm > CALM or others.sum() > FEW) else None


def _from_others(each: Array, u: Array, kept: NDArray[np.bool_]) -> Array:
    """How far each is from the weighted mean of the other kept ones, in standard uncertainties; 0 where it is alone."""
    off = np.zeros(each.size)
    for index in range(each.size):
        others = kept & (np.arange(each.size) != index)
        if others.any():
            weight = u[others] ** -2.0
            mean = float(weight @ each[others] / weight.sum())
            off[index] = (each[index] - mean) / np.hypot(u[index], weight.sum() ** -0.5)
    return off


def _by_chance(chi_square: float, freedom: int) -> float:
    from scipy.special import chdtrc

    return float(chdtrc(freedom, chi_square))

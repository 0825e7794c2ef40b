"""The straight line of length against ratio, how noisy it is, and whether it is straight."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ORDERED = 0.98
"""Lengths more correlated than this with the order they were taken in cannot tell drift from slope."""
ALIKE = 0.01
"""Neighbours that are alike by chance less often than this count as correlated."""


@dataclass(frozen=True, eq=False)
class Line:
    """length = slope ratio + origin, ratios around `mean_ratio`; `residuals` (n,) [m] of lengths; `scatter` [m] of one
    of them, with `freedom` n - 2; `u_slope`; `stretch` of its variance by correlated neighbours, already contained.

    `bend` [m]: standard deviation of the second Legendre polynomial that the line may differ by, over `stroke`.

    Probabilities that chance alone gives such: `p_curved` for a curve (cubic against line), with the largest departure
    `bow` [m]; `p_drift` for a trend with order, None where order and length go together, over the whole run `drift`
    [m]; `p_alike` for neighbours as alike.
    """

    slope: float
    origin: float
    mean_ratio: float
    residuals: Array
    scatter: float
    freedom: int
    u_slope: float
    stretch: float
    stroke: tuple[float, float]
    bend: float
    p_curved: float
    bow: float
    p_drift: float | None
    drift: float
    p_alike: float


def fit_line(ratio: Array, length: Array) -> Line:
    """Least squares of `length` (n,) [m] on `ratio` (n,), in the order they were taken."""
    x = ratio - ratio.mean()
    line = np.stack([x, np.ones_like(x)], axis=1)
    (slope, middle), residuals = _fitted(line, length)
    freedom = x.size - 2
    scatter = float(np.sqrt(residuals @ residuals / freedom))
    share, p_alike = _alike(residuals)
    stretch = (1 + share) / (1 - share) if p_alike < ALIKE else 1.0
    curve = np.stack([x, np.ones_like(x), x**2, x**3], axis=1)
    p_curved, bow = _better(line, curve, residuals, length)
    order = np.arange(x.size) - (x.size - 1) / 2
    together = abs(np.corrcoef(order, x)[0, 1]) > ORDERED
    p_drift, _ = _better(line, np.column_stack([line, order]), residuals, length)
    drift = float(_fitted(np.column_stack([line, order]), length)[0][2] * (x.size - 1))
    return Line(
        slope=float(slope),
        origin=float(middle - slope * ratio.mean()),
        mean_ratio=float(ratio.mean()),
        residuals=residuals,
        scatter=scatter,
        freedom=freedom,
        u_slope=float(scatter * np.sqrt(stretch / (x @ x))),
        stretch=stretch,
        stroke=(float(ratio.min()), float(ratio.max())),
        bend=_bend(ratio, length, scatter),
        p_curved=p_curved,
        bow=bow,
        p_drift=None if together else p_drift,
        drift=drift,
        p_alike=p_alike,
    )


def _fitted(design: Array, data: Array) -> tuple[Array, Array]:
    found = np.asarray(np.linalg.lstsq(design, data, rcond=None)[0], dtype=float)
    return found, data - design @ found


def _bend(ratio: Array, length: Array, scatter: float) -> float:
    """What is seen of a bend and what scatter may hide of it, together."""
    place = 2 * (ratio - ratio.min()) / np.ptp(ratio) - 1
    design = np.stack([np.ones_like(place), place, (3 * place**2 - 1) / 2], axis=1)
    seen = _fitted(design, length)[0][2]
    return float(np.hypot(seen, scatter * np.sqrt(np.linalg.inv(design.T @ design)[2, 2])))


def _better(simple: Array, richer: Array, residuals: Array, data: Array) -> tuple[float, float]:
    """Chance p of the F test of `richer` against `simple`, and the largest difference of what they predict."""
    from scipy.special import fdtrc

    _, left = _fitted(richer, data)
    more, freedom = richer.shape[1] - simple.shape[1], data.size - richer.shape[1]
    gain = residuals @ residuals - left @ left
    if freedom < 1 or left @ left <= 0:
        return 1.0, 0.0
    f = gain / more / (left @ left / freedom)
    return float(fdtrc(more, freedom, max(f, 0.0))), float(np.max(np.abs(left - residuals)))


def _alike(residuals: Array) -> tuple[float, float]:
    """Correlation of neighbours, and p of von Neumann's ratio (about 2 by chance, normal limit) for more of it."""
    from scipy.special import ndtr

    n, square = residuals.size, float(residuals @ residuals)
    if n < 8 or square == 0:
        return 0.0, 1.0
    ratio = float(np.sum(np.diff(residuals) ** 2)) / square
    share = float(np.clip(residuals[1:] @ residuals[:-1] / square, 0.0, 0.9))
    spread = 2 * np.sqrt((n - 2) / (n * n - 1))
    return share, float(ndtr((ratio - 2) / spread))

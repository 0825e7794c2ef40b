"""Bracketed roots of many functions at once."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Function = Callable[[Array, NDArray[np.intp]], Array]

MOST_ROUNDS = 160
HALVED_EVERY = 3  # rounds, so that a kink or a jump costs no more than three times bisection


def bracketed_roots(function: Function, low: Array, high: Array, *, settled: float) -> Array:
    """Where (n,) between `low` and `high` (n,) `function` goes from below 0 (at `low`) to above, within `settled`.

    `function(x, index)` gives the values of the functions `index` at `x`. Illinois' rule: the secant, and where the
    same end stays twice, half its value; where the function jumps, the place of the jump.
    """
    x, every = low.copy(), np.arange(low.size)
    low, high, below, above = low.copy(), high.copy(), function(low, every), function(high, every)
    open_ = np.flatnonzero((below < 0) & (above > 0))
    x[above <= 0] = high[above <= 0]
    side = np.zeros(low.size)
    for n in range(1, MOST_ROUNDS):
        if open_.size == 0:
            break
        a, b, f, g = low[open_], high[open_], below[open_], above[open_]
        new = 0.5 * (a + b) if n % HALVED_EVERY == 0 else np.clip(b - g * (b - a) / (g - f), a, b)
        value = function(new, open_)
        done = (value == 0) | (np.abs(new - x[open_]) <= settled) | (b - a <= settled)
        up = value > 0
        f, g = np.where(up & (side[open_] > 0), f / 2, f), np.where(~up & (side[open_] < 0), g / 2, g)
        low[open_], below[open_] = np.where(up, a, new), np.where(up, f, value)
        high[open_], above[open_] = np.where(up, new, b), np.where(up, value, g)
        side[open_], x[open_] = np.where(up, 1.0, -1.0), new
        open_ = open_[~done]
    return x

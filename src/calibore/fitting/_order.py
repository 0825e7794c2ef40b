"""How many neighbours the noise along chains remembers: Akaike's criterion of the restricted likelihood.

The autocorrelation of residuals would not do: what parameters follow, groups' errors and the chain's own place above
all, is missing from them, and passes for noise that cancels over a chain.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibore.fitting._chains import Autoregression
from calibore.fitting._likelihood import Unknowns, most_likely
from calibore.fitting._mixed import MixedModel, Scatter, Solution

Array = NDArray[np.float64]

LARGEST_ORDER = 12
VALUES_PER_LAG = 4
"""A chain must be so many times as long as the lags it tells about."""
PATIENCE = 2
"""Orders without a gain after which no more are tried."""
PENALTY = 2.0
"""Of the deviance, per lag (Akaike)."""


def largest_order(position: NDArray[np.intp]) -> int:
    """Of chains with values at `position` (n,)."""
    return min(LARGEST_ORDER, (int(position.max(initial=-1)) + 1) // VALUES_PER_LAG)


def of_likeliest_order(
    posed: Callable[[Scatter], tuple[MixedModel, Unknowns]], white: Scatter, *, largest: int
) -> tuple[Solution, Unknowns]:
    """The most likely scatter, with as many lags as the data ask for, from `white` noise on; `posed` gives the model
    with the order of a scatter, and what is searched for from there.
    """
    start, least, chosen, best = white, np.inf, 0, None
    for order in range(largest + 1):
        model, unknowns = posed(start)
        solution = model.at(most_likely(model, unknowns))
        criterion = solution.deviance(restricted=True) + PENALTY * order
        if best is None or criterion < least:
            least, chosen, best = criterion, order, (solution, unknowns)
        elif order - chosen >= PATIENCE:
            break
        found = solution.scatter
        start = Scatter(found.innovation, found.group, Autoregression(np.append(found.chain.partial, 0.0)))
    assert best is not None
    return best

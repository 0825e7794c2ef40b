"""Which of several takes of one position contradicts all the others (Hueser and Rothe 1998; Swanbom 2007, 2.3.5).

A drop, a glint, a passer-by: one take sees something that the others do not. Compared with the consensus of the others
it stands alone, and is left out. Two takes cannot tell which of them is wrong, nor can two against two.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FEWEST = 3
"""Takes of which one can be told to stand alone."""
ALONE = 6.0
"""Standard uncertainties from the others' median beyond which a take stands alone; the others must all lie nearer."""


def agreeing(values: Array, u: Array) -> NDArray[np.bool_]:
    """Which takes (t, n) of n positions take part: `values` (t, n), NaN where a take has none, with their independent
    standard uncertainties `u` (t, n). A take is left out where it alone contradicts the others, two of them at least.
    """
    seen = np.isfinite(values)
    if len(values) < FEWEST or not (seen.sum(axis=0) >= FEWEST).any():
        return seen
    alone = np.stack([_stands_alone(number, values, u) for number in range(len(values))])
    return seen & ~(alone & (alone.sum(axis=0) == 1))


def _stands_alone(number: int, values: Array, u: Array) -> NDArray[np.bool_]:
    """Where (n,) take `number` contradicts others that agree."""
    others, u_others = np.delete(values, number, axis=0), np.delete(u, number, axis=0)
    enough = np.isfinite(others).sum(axis=0) >= FEWEST - 1
    middle = np.full(values.shape[1], np.nan)
    middle[enough] = np.nanmedian(others[:, enough], axis=0)
    away = np.abs(others - middle) > ALONE * u_others
    return enough & (np.abs(values[number] - middle) > ALONE * u[number]) & ~away.any(axis=0)

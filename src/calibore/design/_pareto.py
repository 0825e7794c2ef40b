"""The designs that no other beats in everything, and a few of them that stand for all."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def non_dominated(costs: Array) -> NDArray[np.intp]:
    """Indices, ascending, of the rows of `costs` (n, m), less is better, that no other row beats in one cost without
    losing in another; of equal rows the first.
    """
    order = np.lexsort((np.arange(len(costs)), *costs.T[::-1]))
    front = np.empty((len(costs), costs.shape[1]))
    kept: list[int] = []
    for row in order:
        if not (front[: len(kept)] <= costs[row]).all(axis=1).any():
            front[len(kept)] = costs[row]
            kept.append(int(row))
    return np.sort(np.array(kept, dtype=np.intp))


def spread(costs: Array, count: int) -> NDArray[np.intp]:
    """Indices, ascending, of at most `count` rows of `costs` (n, m): the best in each cost, then always the row
    farthest from those chosen, every cost scaled by its range.
    """
    if len(costs) <= count:
        return np.arange(len(costs))
    least, most = costs.min(axis=0), costs.max(axis=0)
    scaled = (costs - least) / np.where(most > least, most - least, 1.0)
    chosen = list(dict.fromkeys(int(np.lexsort((scaled.sum(axis=1), column))[0]) for column in scaled.T))[:count]
    away = np.min([np.linalg.norm(scaled - scaled[row], axis=1) for row in chosen], axis=0)
    while len(chosen) < count and away.max() > 0:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(scaled - scaled[chosen[-1]], axis=1))
    return np.sort(np.array(chosen, dtype=np.intp))

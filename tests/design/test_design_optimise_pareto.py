"""Pareto sets: nothing in them is beaten, nothing outside them is unbeaten."""

import numpy as np
import pytest

from calibore.design import non_dominated, spread


def _dominated(costs: np.ndarray) -> np.ndarray:
    """(n,) by comparing all with all."""
    no_worse = (costs[None] <= costs[:, None]).all(axis=2)
    better = (costs[None] < costs[:, None]).any(axis=2)
    return (no_worse & better).any(axis=1)


@pytest.mark.parametrize("seed", range(20))
def test_the_pareto_set_is_what_comparing_all_with_all_leaves(seed):
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, 8, size=(rng.integers(1, 120), rng.integers(1, 5))).astype(float)
    kept = non_dominated(costs)
    unbeaten = costs[~_dominated(costs)]
    assert {tuple(row) for row in costs[kept]} == {tuple(row) for row in unbeaten}
    assert len({tuple(row) for row in costs[kept]}) == len(kept)
    assert (np.diff(kept) > 0).all()


@pytest.mark.parametrize("seed", range(10))
def test_few_designs_that_stand_for_all_hold_the_best_of_each_kind(seed):
    rng = np.random.default_rng(seed)
    costs = rng.uniform(size=(200, 4))
    chosen = spread(costs, 12)
    assert len(chosen) == len(set(chosen)) == 12
    assert (costs[chosen].min(axis=0) == costs.min(axis=0)).all()


def test_spread_designs_lie_farther_apart_than_the_first_ones_found():
    rng = np.random.default_rng(3)
    costs = np.sort(rng.uniform(size=(400, 2)), axis=0)
    costs[:, 1] = 1 - costs[:, 1]
    chosen = costs[spread(costs, 10)]
    gaps = np.linalg.norm(np.diff(chosen[np.argsort(chosen[:, 0])], axis=0), axis=1)
    assert gaps.min() > 0.5 * np.sqrt(2) / 10


def test_equal_designs_are_shown_once():
    assert len(spread(np.zeros((30, 3)), 5)) == 1
    assert non_dominated(np.zeros((30, 3))).tolist() == [0]

"""The path of the wall round the ring: the sequence of whole chains that explains most of the light.

A chain is worth its light: the square roots of its heights over the line's usual height, none above 1, summed, so one
for every ray of clear line. A line does not end where another begins beside it, and does not begin in the middle of
another: so the wall is a sequence of whole chains, one after the other round the ring, each there or not. Where one
follows the other without a jump it costs nothing, over a gap of any length; a jump, as at an edge of the wall, costs
`JUMP` rays of clear line, and more over a gap: what lies alone and off the ring must be long to be wall. Where both
are seen side by side the light of one is lost, and further than at an edge, that once more: then one of them is not the
wall. The best of all closed sequences is found exactly, by dynamic programming from each chain once round to itself.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._chain import LONGEST_GAP, SLACK, STEEPEST, Chain

Array = NDArray[np.float64]
JUMP = 8.0
"""Rays of clear line that a jump costs, ..."""
GAP_JUMP, LONGEST_COUNTED = 2.0, 24.0
"""... and as many more for each of the first rays of the gap that it leaps over: what lies alone and off the ring must
be twice as long, with a jump at each end."""
WANDER = 0.25
"""Pixels along the ray per pixel across it, that a wall may wander in a gap longer than `LONGEST_GAP`."""
EDGE = 6.0
"""Rays on which both sides of an edge are seen."""
MOST_CHAINS = 32
"""Those with most light take part."""


class Path(NamedTuple):
    """Numbers of the chains that are its `members`, the `light` they hold less what their jumps cost, and by how much
    of it, `gain` (m,), this is more than the most that a path without each of the chains has.
    """

    light: float
    members: list[int]
    gain: Array


def best_path(
    chains: Sequence[Chain],
    light: Array,
    *,
    rays: int,
    spacing: float,
    closed: bool,
    stride: int,
    slack: float = SLACK,
) -> Path:
    """The wall among the `chains`, each of which holds `light` (m,); `rays` of this scan, each one for `stride`, lie
    `spacing` [px] apart; `slack` see `link`.
    """
    count = len(chains)
    how: dict[str, Any] = {"rays": rays, "spacing": spacing, "closed": closed, "stride": stride, "slack": slack}
    cost = np.array([_cost(a, b, **how) for a in chains for b in chains]).reshape(count, count)
    head = np.array([chain.head[0] for chain in chains], dtype=np.intp)
    if not closed:
        light, cost, head = np.append(light, 0.0), np.pad(cost, (0, 1)), np.append(head, -1)
    best, members, without = 0.0, [], np.zeros(len(light))
    for first in range(count) if closed else [count]:
        turned = np.mod(head - head[first], rays) if closed else head
        order = sorted(range(len(light)), key=lambda c: (c != first, turned[c], c))
        found, others = _from_first(order, light, cost)
        if found.light > best:
            best, members = found.light, found.members
        without[order] = np.maximum(without[order], others)
    return Path(best, [c for c in members if c < count], best - without[:count])


def steps_between(a: Chain, b: Chain, *, rays: int, closed: bool) -> int:
    """Rays from the end of `a` to the beginning of `b`, its next time; less than 1 where both are seen."""
    ahead = b.head[0] - a.head[0]
    if closed:
        ahead = ahead % rays or (rays if a is b else 0)
    return ahead - (a.tail[0] - a.head[0])


def _cost(a: Chain, b: Chain, *, rays: int, spacing: float, stride: int, closed: bool, slack: float = SLACK) -> float:
    """What it costs that `b` follows `a`; infinite where it cannot."""
    steps = steps_between(a, b, rays=rays, closed=closed)
    if steps + b.tail[0] - b.head[0] <= 0 or (not closed and b.head[0] <= a.head[0]):
        return np.inf
    if steps < 1:
        shared = (1.0 - steps) * stride
        return JUMP + shared + max(0.0, shared - EDGE)
    near = min(steps, LONGEST_GAP + 1)
    if abs(b.head[1] - a.tail[1]) <= slack + spacing * (STEEPEST * near + WANDER * (steps - near)):
        return 0.0
    return JUMP + GAP_JUMP * min((steps - 1.0) * stride, LONGEST_COUNTED)


def _from_first(order: list[int], light: Array, cost: Array) -> tuple[Path, Array]:
    """The best path from the first chain in `order` through those after it back to it, and the light of the best one
    that leaves out each (in the same order; none leaves out the first).
    """
    count, first = len(order), order[0]
    forth, back = np.empty(count), np.empty(count)
    before = [0] * count
    forth[0] = light[first]
    for j in range(1, count):
        reached = [forth[i] - cost[order[i], order[j]] for i in range(j)]
        before[j] = int(np.argmax(reached))
        forth[j] = light[order[j]] + reached[before[j]]
    for i in reversed(range(count)):
        onwards = [light[order[j]] - cost[order[i], order[j]] + back[j] for j in range(i + 1, count)]
        back[i] = max([-cost[order[i], first], *onwards])
    ends = [forth[i] - cost[order[i], first] for i in range(count)]
    others = np.full(count, -np.inf)
    for i in range(count):
        for j in range(i + 2, count + 1):
            leap = ends[i] if j == count else forth[i] - cost[order[i], order[j]] + light[order[j]] + back[j]
            others[i + 1 : j] = np.maximum(others[i + 1 : j], leap)
    members, at = [], int(np.argmax(ends))
    best = ends[at]
    while at:
        members.append(order[at])
        at = before[at]
    return Path(best, [first, *reversed(members)], others), others

"""Choosing the line among the candidates: what lies on the best path round the ring (`_chain`, `_path`).

1. Candidates that look like laser light (`_light`) form chains; one of fewer than `SHORTEST` rays is no line, unless it
   was torn off one: spatter, a hot pixel (OFF_RING).
2. The wall is the sequence of chains that explains most light (`_path`); what else there is is not (OFF_RING).
3. The line had a rival (RESOLVED) where another candidate stands in a chain of `SHORTEST` rays, or is at least `SLIGHT`
   times as high as the highest on the ray; lower ones that continue nothing are the ripples of noise and compression,
   and no rivals (OK).
4. The confidence is the share of its own light that the path would lose without the chain, 0 where another course is
   as good, times n / (n + `SHORTEST`) for a chain of n rays, for a short one may be anything. Below `UNSURE` there is
   no number: nobody can tell it from its rival (MULTIPLE), or whether it is wall at all (OFF_RING).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.status import Status
from calibore.stripe._chain import LONGEST_GAP, SHORTEST, SLACK, SLIGHT, Chain, link
from calibore.stripe._path import MOST_CHAINS, best_path, steps_between

Array = NDArray[np.float64]
UNSURE = 0.2
"""A reflection that is two thirds as bright as what it reflects has as much light (its square root) but for this."""


class Choice(NamedTuple):
    """Column of the chosen candidate, status and confidence (0 to 1) per ray, (n,) each; the first and last have no
    meaning where the status has no value.
    """

    pick: NDArray[np.intp]
    status: NDArray[np.uint8]
    confidence: Array


def choose(
    position: Array,
    height: Array,
    laser: NDArray[np.bool_],
    *,
    spacing: float,
    closed: bool,
    stride: int = 1,
    slack: float = SLACK,
) -> Choice:
    """The line among candidates at `position` [px] of `height`, highest first, (n, k) each, NaN where there is none;
    `laser`: which look like its light. Rays lie `spacing` [px] apart, each one for `stride`; `slack` see `link`.
    """
    place = np.where(laser, position, np.nan)
    chains, number = link(place, height, spacing=spacing, closed=closed, stride=stride, slack=slack)
    light = _light_of(height, number, len(chains)) * stride
    long = np.array([chain.members * stride >= SHORTEST for chain in chains], dtype=bool)
    kept = _most(light, long | np.array([chain.torn and chain.members > 0 for chain in chains], dtype=bool))
    some = [chains[c] for c in kept]
    how: dict[str, Any] = {"rays": len(position), "closed": closed, "stride": stride}
    path = best_path(some, light[kept], spacing=spacing, slack=slack, **how)
    confidence = np.full(len(chains) + 1, -1.0)
    for c in _connected(path.members, some, **how):
        length = float(some[c].members * stride)
        confidence[kept[c]] = np.clip(path.gain[c] / light[kept[c]], 0.0, 1.0) * (length / (length + SHORTEST))
    return _stated(height, number, np.append(long, False), confidence, np.isfinite(position))


def _light_of(height: Array, number: NDArray[np.intp], chains: int) -> Array:
    """Light (m,) of the chains, in rays of clear line."""
    own = number >= 0
    if not own.any():
        return np.zeros(chains)
    usual = np.median(np.max(np.where(own, height, -np.inf), axis=1)[own.any(axis=1)])
    share = np.sqrt(np.minimum(height[own] / usual, 1.0))
    return np.bincount(number[own], weights=share, minlength=chains).astype(np.float64)


def _most(light: Array, eligible: NDArray[np.bool_]) -> NDArray[np.intp]:
    """The `eligible` chains with most light, in their order."""
    which = np.flatnonzero(eligible)
    return np.sort(which[np.argsort(-light[which], kind="stable")][:MOST_CHAINS])


def _connected(members: list[int], chains: list[Chain], *, rays: int, closed: bool, stride: int) -> list[int]:
    """Those `members` of a path which, with those that they are connected to, are long enough for a line."""
    groups: list[list[int]] = []
    turn: Any = {"rays": rays, "closed": closed}
    for before, c in zip([None, *members], members, strict=False):
        near = before is not None and steps_between(chains[before], chains[c], **turn) <= LONGEST_GAP + 1
        if near:
            groups[-1].append(c)
        else:
            groups.append([c])
    ends = len(groups) > 1 and closed
    if ends and steps_between(chains[members[-1]], chains[members[0]], **turn) <= LONGEST_GAP + 1:
        groups[0] += groups.pop()
    return [c for group in groups if sum(chains[c].members for c in group) * stride >= SHORTEST for c in group]


def _stated(
    height: Array, number: NDArray[np.intp], long: NDArray[np.bool_], confidence: Array, found: NDArray[np.bool_]
) -> Choice:
    """Pick, status and confidence of each ray, from which chains are `long` and the `confidence` of those on the path,
    (m + 1,) each, -1 beside it.
    """
    rows, own = np.arange(len(height)), number >= 0
    of_path = confidence[number] >= 0
    pick = np.argmax(np.where(of_path, height, -np.inf), axis=1)
    seen, sure = of_path[rows, pick], confidence[number[rows, pick]]
    highest = np.max(np.where(own, height, -np.inf), axis=1)
    others = own & (long[number] | (height >= SLIGHT * highest[:, None]))
    others[rows, pick] = False
    rival = others.any(axis=1)
    status = np.where(rival, Status.RESOLVED, Status.OK)
    status = np.where(sure < UNSURE, np.where(rival, Status.MULTIPLE, Status.OFF_RING), status)
    status[~seen] = Status.OFF_RING
    status[~own.any(axis=1)] = Status.NOT_LASER
    status[~found.any(axis=1)] = Status.NO_PEAK
    return Choice(pick, status.astype(np.uint8), np.where(seen, sure, 0.0))

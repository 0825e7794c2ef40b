"""Dark rings counted: dips joined to chains from ray to ray, chains joined across spokes, numbered from the inside."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Array, Whole
from calibore.targets._rings_dips import RAYS, Dips, find_dips
from calibore.targets._rings_spokes import Spoke

BLENDED = 2.0
"""px beside a spoke in which its blur hides rings."""
SAME_LINE = 0.35
"""Dips of neighbouring rays within this fraction of the distance to the next dip lie on one ring."""
GAP = 3
"""Rays over which a chain goes on without a dip."""
SHORTEST = 8
"""Rays: shorter chains are dirt."""
TREND = 16
"""Dips at the end of a chain that tell where it goes on behind a spoke."""
WIDEST_SPOKE = 16.0
"""px of a ring that a spoke and its blur may hide."""
MIDDLE = 0.25
"""Rings are counted on rays at least this fraction of a sector away from the spokes."""
AGREEING = 0.25
"""The number of a ring is the highest that so many of its counted rays agree on: an inner ring may be missed on the
others, but is rarely invented.
"""


def count_rings(plane: Array, centre: Array, spokes: tuple[Spoke, ...]) -> Dips:
    """The dips of a picture (h, w) round the `centre` with the rings they belong to."""
    dips = find_dips(plane, centre)
    azimuth = dips.azimuths[dips.ray]
    dips = dips.kept(beside_spokes(spokes, azimuth, dips.radius) > 0.6 * dips.width + BLENDED)
    chain = _chains(dips.ray, dips.radius)
    long = np.bincount(chain, minlength=1)[chain] >= SHORTEST
    dips, chain = dips.kept(long), np.unique(chain[long], return_inverse=True)[1].astype(np.intp)
    ring = _across_spokes(dips, chain)[chain]
    counted = _in_the_middle(spokes, dips.azimuths)[dips.ray]
    return replace(dips, ring=_numbers(dips.ray, dips.radius, ring, counted))


def beside_spokes(spokes: tuple[Spoke, ...], azimuth: Array, radius: Array) -> Array:
    """Distance (n,) [px] of places from the midline of the nearest spoke."""
    nearest = np.full(radius.shape, np.inf)
    for spoke in spokes:
        turn = azimuth - spoke.azimuth
        along, across = radius * np.cos(turn), radius * np.sin(turn)
        distance = np.where(along > 0, np.abs(across - spoke.offset(np.clip(along, 0, spoke.length))), np.inf)
        nearest = np.minimum(nearest, distance)
    return nearest


def _in_the_middle(spokes: tuple[Spoke, ...], azimuths: Array) -> NDArray[np.bool_]:
    """Rays far from both spokes beside them."""
    starts = np.sort([spoke.azimuth for spoke in spokes])
    after = np.searchsorted(starts, azimuths) % starts.size
    before = after - 1
    sector = (starts[after] - starts[before]) % (2 * np.pi)
    part = ((azimuths - starts[before]) % (2 * np.pi)) / np.where(sector > 0, sector, 2 * np.pi)
    return np.abs(part - 0.5) < 0.5 - MIDDLE


def _chains(ray: Whole, radius: Array) -> Whole:
    """The chain (n,) of each dip: dips of rays close by that are each other's nearest."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    starts = np.searchsorted(ray, np.arange(RAYS + 1))
    room = _room(ray, radius)
    pairs = []
    joined = np.zeros(ray.size, dtype=bool)
    for gap in range(1, GAP + 1):
        for here in range(RAYS):
            there = (here + gap) % RAYS
            first = np.arange(starts[here], starts[here + 1])
            second = np.arange(starts[there], starts[there + 1])
            first = first[~joined[first]]
            if first.size == 0 or second.size == 0:
                continue
            apart = np.abs(radius[first][:, None] - radius[second])
            to, back = apart.argmin(axis=1), apart.argmin(axis=0)
            mutual = back[to] == np.arange(first.size)
            close = apart[np.arange(first.size), to] < SAME_LINE * np.minimum(room[first], room[second[to]])
            good = mutual & close
            joined[first[good]] = True
            pairs.append(np.stack([first[good], second[to][good]], axis=1))
    if not pairs:
        return np.zeros(0, dtype=np.intp)
    a, b = np.concatenate(pairs).T
    graph = coo_matrix((np.ones(a.size), (a, b)), shape=(ray.size, ray.size))
    return connected_components(graph, directed=False)[1].astype(np.intp)


def _room(ray: Whole, radius: Array) -> Array:
    """Distance (n,) [px] from each dip to its neighbour on the same ray, inwards or outwards, whichever is nearer."""
    step = np.diff(radius)
    step[np.diff(ray) != 0] = np.inf
    room = np.minimum(np.append(step, np.inf), np.append(np.inf, step))
    return np.where(np.isfinite(room), room, radius)


def _across_spokes(dips: Dips, chain: Whole) -> Whole:
    """The ring (chains,) to which each chain belongs: ends of chains that point at one another across a spoke."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = int(chain.max(initial=-1)) + 1
    first, last, room = _ends(dips, chain, count)
    gap = (first[:, 0] - last[:, :1]) % RAYS
    middle = last[:, 1:2] + last[:, 2:] * gap / 2
    apart = np.abs(middle - (first[:, 1] - first[:, 2] * gap / 2))
    hidden = gap * (2 * np.pi / RAYS) * last[:, 1:2]
    near = (hidden < WIDEST_SPOKE + 2 * room[:, None] * SAME_LINE) & (gap < RAYS / 8)
    near &= apart < SAME_LINE * np.minimum(room[:, None], room)
    apart = np.where(near, apart, np.inf)
    to, back = (apart.argmin(axis=axis) if count else np.zeros(0, dtype=np.intp) for axis in (1, 0))
    mutual = np.flatnonzero((back[to] == np.arange(count)) & np.isfinite(apart.min(axis=1, initial=np.inf)))
    graph = coo_matrix((np.ones(mutual.size), (mutual, to[mutual])), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.intp)


def _ends(dips: Dips, chain: Whole, count: int) -> tuple[Array, Array, Array]:
    """Ray, radius [px] and slope [px per ray] at the first and at the last ray of each chain (chains, 3), and the
    distance (chains,) [px] to its neighbours.
    """
    room = _room(dips.ray, dips.radius)
    first, last, typical = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    for name in range(count):
        member = np.flatnonzero(chain == name)
        ray, radius = _unwrapped(dips.ray[member]), dips.radius[member]
        order = np.argsort(ray, kind="stable")
        for end, part in ((first, order[:TREND]), (last, order[-TREND:])):
            slope, level = np.polyfit(ray[part] - ray[part].mean(), radius[part], 1)
            edge = ray[part][0] if end is first else ray[part][-1]
            end[name] = edge % RAYS, level + slope * (edge - ray[part].mean()), slope
        typical[name] = np.median(room[member])
    return first, last, typical


def _unwrapped(ray: Whole) -> Whole:
    """The rays of one chain without the jump from the last ray to the first, beginning after its longest gap."""
    present = np.unique(ray)
    gaps = np.diff(present, append=present[0] + RAYS)
    start = present[(int(gaps.argmax()) + 1) % present.size]
    return (ray - start) % RAYS + start


def _numbers(ray: Whole, radius: Array, ring: Whole, counted: NDArray[np.bool_]) -> Whole:
    """The number (n,) of the ring of each dip, 0 where too few rays agree: its place in the row outwards."""
    order = np.lexsort((radius, ray))
    place = np.empty(ray.size, dtype=np.intp)
    place[order] = np.arange(ray.size) - np.searchsorted(ray[order], ray[order]) + 1
    votes = np.zeros((int(ring.max(initial=0)) + 1, int(place.max(initial=0)) + 1))
    np.add.at(votes, (ring[counted], place[counted]), 1)
    agreed = votes >= AGREEING * np.maximum(votes.sum(axis=1, keepdims=True), 1)
    best = np.where(agreed.any(axis=1), agreed.shape[1] - 1 - agreed[:, ::-1].argmax(axis=1), 0)
    return best[ring]

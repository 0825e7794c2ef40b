"""Dark rings counted: dips of brightness along rays from the centre, joined round the azimuth, numbered outwards."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Array, Whole
from calibore.targets._rings_spokes import Spoke

RAYS = 1440
STEP = 0.5
"""px along a ray."""
SMOOTHING = 0.6
"""Gaussian [px] over the picture before rays are read; along the azimuth rays are averaged over `BESIDE` rays too."""
BESIDE = 1.0
SHALLOWEST, NOISIEST = 0.035, 7.0
"""A dip is at least this fraction of the paper's brightness deep, and this many standard deviations of the noise."""
DARKEST_PAPER = 0.3
"""Paper is at least this bright, relative to the paper near the centre."""
END_OF_PAPER = 0.6
"""Beyond the last place so bright, relative to the paper beside the outermost dip, a ray has left the paper."""
NEAREST = 4.0
"""px from the centre to the first ring, at least."""
BLENDED = 2.0
"""px beside a spoke in which its blur hides rings."""
SAME_LINE = 0.35
"""Dips of neighbouring rays within this fraction of the distance to the next dip lie on one ring."""
GAP = 3
"""Rays over which a ring may be interrupted and still be followed."""
SHORTEST = 8
"""Rays: shorter chains are dirt."""
MIDDLE = 0.25
"""Rings are counted on rays at least this fraction of a sector away from the spokes."""
MAJORITY = 0.6
"""Of its rays that must agree on a chain's number."""


@dataclass(frozen=True, eq=False)
class Dips:
    """Dark lines crossed by rays: number of the `ray` (n,), distance `radius` [px], `width` [px] at half depth, `depth`
    as a fraction of the paper's brightness, and the ring's number `ring` (n,) from 1, 0 where not known; `azimuths`
    (rays,) [rad]; `paper` (rays,) [px]: how far each ray stays on paper, infinite where the picture ends first.
    """

    ray: Whole
    radius: Array
    width: Array
    depth: Array
    ring: Whole
    azimuths: Array
    paper: Array


def count_rings(plane: Array, centre: Array, spokes: tuple[Spoke, ...]) -> Dips:
    """All dips of a picture (h, w) round the `centre` and the rings they belong to."""
    azimuths = np.arange(RAYS) * (2 * np.pi / RAYS)
    profiles, ends = _profiles(plane, centre, azimuths)
    ray, radius, width, depth, paper = _dips(profiles, ends)
    free = beside_spokes(spokes, azimuths[ray], radius) > 0.6 * width + BLENDED
    ray, radius, width, depth = ray[free], radius[free], width[free], depth[free]
    chain = _chains(ray, radius)
    long = np.bincount(chain, minlength=1)[chain] >= SHORTEST
    ray, radius, width, depth, chain = ray[long], radius[long], width[long], depth[long], chain[long]
    counted = _in_the_middle(spokes, azimuths)[ray]
    return Dips(ray, radius, width, depth, _numbers(ray, radius, chain, counted), azimuths, paper)


def _profiles(plane: Array, centre: Array, azimuths: Array) -> tuple[Array, Whole]:
    """Brightness (rays, steps) along the rays, and how many steps of each lie in the picture."""
    from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates

    height, width = plane.shape
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]]) - centre
    radius = np.arange(0, np.hypot(*corners.T).max(), STEP)
    u = centre[0] + radius * np.cos(azimuths)[:, None]
    v = centre[1] + radius * np.sin(azimuths)[:, None]
    smooth = gaussian_filter(plane.astype(np.float32), SMOOTHING)
    profiles = map_coordinates(smooth, [v, u], order=1, mode="nearest")
    inside = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    return gaussian_filter1d(profiles, BESIDE, axis=0, mode="wrap"), inside.sum(axis=1)


def _dips(profiles: Array, ends: Whole) -> tuple[Whole, Array, Array, Array, Array]:
    """Ray (n,), distance [px] of the middle between the flanks, width at half depth [px] and relative depth of all dark
    lines; where each ray leaves the paper.
    """
    from scipy.signal import find_peaks

    paper = np.quantile(profiles[:, : int(ends.max()) // 4], 0.8)
    noise = np.median(np.abs(np.diff(profiles, n=2, axis=0))) / 0.6745 / np.sqrt(6)
    least = max(NOISIEST * noise, 0.3 * SHALLOWEST * paper)
    found, leaves = [], ends * STEP
    for ray, (profile, end) in enumerate(zip(profiles, ends, strict=True)):
        line = profile[:end]
        index, about = find_peaks(-line, prominence=least, width=0, rel_height=0.5)
        depth, left, right = about["prominences"], about["left_ips"] * STEP, about["right_ips"] * STEP
        shoulder = line[index] + depth
        kept = (depth > SHALLOWEST * shoulder) & (shoulder > DARKEST_PAPER * paper) & (left + right > 2 * NEAREST)
        found.append((np.full(index.size, ray), (left + right) / 2, right - left, depth / shoulder, kept))
        if kept.any():
            bright = np.flatnonzero(line > END_OF_PAPER * shoulder[kept][-1])[-1]
            leaves[ray] = bright * STEP
    ray, radius, width, depth, kept = (np.concatenate(part) for part in zip(*found, strict=True))
    return ray[kept], radius[kept], width[kept], depth[kept], leaves


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


def _numbers(ray: Whole, radius: Array, chain: Whole, counted: NDArray[np.bool_]) -> Whole:
    """The ring (n,) of each dip: the place in the row outwards on which most of the counted rays of its chain agree."""
    order = np.lexsort((radius, ray))
    first = np.searchsorted(ray[order], ray[order])
    place = np.empty(ray.size, dtype=np.intp)
    place[order] = np.arange(ray.size) - first + 1
    number = np.zeros(ray.size, dtype=np.intp)
    for name in np.unique(chain):
        member = chain == name
        votes = np.bincount(place[member & counted], minlength=2)
        best = int(votes.argmax())
        if votes[best] > MAJORITY * votes.sum():
            number[member] = best
    return number

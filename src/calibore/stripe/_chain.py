"""Choosing the line among the candidates: the rule of continuity.

1. Candidates of neighbouring rays are linked when they could be one line: at most `STEEPEST` pixels along the ray per
   pixel across, over at most `LONGEST_GAP` empty rays. Linked candidates form a chain.
2. A chain of fewer than `SHORTEST` rays is not the line: spatter, a hot pixel (OFF_RING).
3. On a ray with several candidates the one in the longest chain is the line. It had a rival (RESOLVED) if another one
   stands in a chain of `SHORTEST` rays, or at least `SLIGHT` times as high as the highest on the ray; lower ones that
   continue nothing are the ripples of noise and compression, and no rivals (OK).
4. Where the rival's chain counts (2) and is more than `RIVAL` times as long, nobody can tell: no number (MULTIPLE).
"""

import numpy as np
from numpy.typing import NDArray

from calibore.status import Status

Array = NDArray[np.float64]
STEEPEST = 2.0
"""Pixels along the ray per pixel across it."""
SLACK = 1.0
"""Pixels a peak may jump besides, for its noise."""
LONGEST_GAP = 3
"""Rays."""
SHORTEST = 10
"""Rays."""
SLIGHT = 0.15
RIVAL = 0.5


def link(position: Array, *, spacing: float, closed: bool) -> NDArray[np.int64]:
    """Length in rays of the chain each candidate (n, k) belongs to; 0 where there is no candidate.

    Candidates stand highest first in their row; each chain takes at most one per ray, the nearest.
    """
    count, most = position.shape
    chain = np.full((count, most), -1, dtype=np.int64)
    heads: list[tuple[int, float]] = []
    tails: list[tuple[int, float]] = []
    members: list[int] = []
    active: list[int] = []
    for ray in range(count):
        active = [c for c in active if ray - tails[c][0] <= LONGEST_GAP + 1]
        for k in range(most):
            place = position[ray, k]
            if not np.isfinite(place):
                continue
            c = _nearest(place, ray, active, tails, spacing)
            if c < 0:
                c = len(heads)
                heads.append((ray, place))
                tails.append((ray, place))
                members.append(0)
                active.append(c)
            tails[c], chain[ray, k] = (ray, place), c
            members[c] += 1
    root = _join_ends(heads, tails, spacing, count) if closed else list(range(len(heads)))
    length = np.zeros(len(heads) + 1, dtype=np.int64)
    for c, r in enumerate(root):
        length[r] += members[c]
    return np.where(chain >= 0, length[np.asarray([*root, len(heads)])[chain]], 0)


def _nearest(place: float, ray: int, active: list[int], tails: list[tuple[int, float]], spacing: float) -> int:
    """The active chain whose tail this candidate continues best, or -1."""
    best, answer = np.inf, -1
    for c in active:
        steps = ray - tails[c][0]
        jump = abs(place - tails[c][1])
        if steps > 0 and jump <= SLACK + STEEPEST * spacing * steps and jump < best:
            best, answer = jump, c
    return answer


def _join_ends(heads: list[tuple[int, float]], tails: list[tuple[int, float]], spacing: float, count: int) -> list[int]:
    """Chain numbers after joining chains that meet where a closed scan begins and ends."""
    root = list(range(len(heads)))
    for c, (last, end) in enumerate(tails):
        for d, (first, begin) in enumerate(heads):
            steps = first + count - last
            if steps <= LONGEST_GAP + 1 and abs(end - begin) <= SLACK + STEEPEST * spacing * steps:
                old, new = root[c], root[d]
                root = [new if r == old else r for r in root]
    return root


def choose(
    length: NDArray[np.int64], laser: NDArray[np.bool_], height: Array
) -> tuple[NDArray[np.intp], NDArray[np.uint8]]:
    """(column of the chosen candidate, status) per ray, both (n,), by the rule above.

    Chain `length` (n, k) [rays], 0 = no candidate; which of them are `laser` light (n, k); their `height` (n, k). The
    column is meaningless where the status has no value.
    """
    rows = np.arange(len(length))
    eligible = np.where(laser, length, 0)
    pick = np.argmax(eligible, axis=1)
    best = eligible[rows, pick]
    highest = np.max(np.where(eligible > 0, height, 0.0), axis=1)
    others = np.where((eligible >= SHORTEST) | (height >= SLIGHT * highest[:, None]), eligible, 0)
    others[rows, pick] = 0
    rival = others.max(axis=1)
    status = np.full(len(length), Status.OK, dtype=np.uint8)
    status[rival > 0] = Status.RESOLVED
    status[(rival > RIVAL * best) & (rival >= SHORTEST)] = Status.MULTIPLE
    status[best < SHORTEST] = Status.OFF_RING
    status[(best == 0) & (length > 0).any(axis=1)] = Status.NOT_LASER
    status[(length == 0).all(axis=1)] = Status.NO_PEAK
    return pick, status

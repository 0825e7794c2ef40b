"""Linking candidates of neighbouring rays into chains: the rule of continuity.

Candidates of neighbouring rays are linked when they could be one line: at most `STEEPEST` pixels along the ray per
pixel across, over at most `LONGEST_GAP` empty rays. Linked candidates form a chain; each takes at most one per ray, the
nearest. Where two lines meet or part, nobody can tell at once which goes on where: the chains end there, new ones
begin, and what belongs together is decided by the whole ring (`_path`).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEPEST = 2.0
"""Pixels along the ray per pixel across it."""
SLACK, LOOSE = 1.0, 0.8
"""Pixels a peak may jump besides, for its noise, or line widths: speckle breaks a wide line into grains, any of which
may be the brightest place of its ray."""
LONGEST_GAP = 3
"""Rays."""
SHORTEST = 10
"""Rays; fewer are no line."""
SLIGHT = 0.15
"""Times as high as another peak: below this a peak continues nothing that the other continues."""

Place = tuple[int, float]
"""Ray, and position along it [px]."""
Peak = tuple[float, float]
"""Position [px] and height."""


@dataclass
class Chain:
    """From `head` to `tail` over `members` candidates. A closed ring's may begin in the turn before, at a ray below 0.
    `torn`: it begins or ends where lines meet or part.
    """

    head: Place
    tail: Place
    members: int = 0
    torn: bool = False


def link(
    position: Array, height: Array, *, spacing: float, closed: bool, stride: int = 1, slack: float = SLACK
) -> tuple[list[Chain], NDArray[np.intp]]:
    """Chains, and which of them each candidate (n, k) belongs to, -1 where `position` [px] is NaN.

    Candidates stand highest first in their row. `spacing` [px] of the rays, each of which stands for `stride`; `slack`
    [px] that a peak may jump for its noise.
    """
    room = Room(slack, spacing)
    number = np.full(position.shape, -1, dtype=np.intp)
    chains: list[Chain] = []
    active: list[int] = []
    for ray, row in enumerate(position):
        active = [c for c in active if ray - chains[c].tail[0] <= LONGEST_GAP + 1]
        places = [(k, float(place)) for k, place in enumerate(row) if np.isfinite(place)]
        torn = _torn(chains, active, ray, [(place, height[ray, k]) for k, place in places], room, stride)
        for c in torn:
            chains[c].torn = True
        active = [c for c in active if c not in torn]
        for k, place in places:
            c = _nearest(chains, active, ray, place, room)
            if c is None:
                c = len(chains)
                chains.append(Chain((ray, place), (ray, place), 0, bool(torn)))
                active.append(c)
            chains[c].tail = (ray, place)
            chains[c].members += 1
            number[ray, k] = c
    return _joined(chains, number, len(position), room) if closed else (chains, number)


def slack_of(width: float) -> float:
    """How far [px] a peak of a line of `width` [px] may jump for its noise."""
    return max(SLACK, LOOSE * width)


class Room(NamedTuple):
    """How far a line may move along its rays: for its noise, and per ray that lies `spacing` [px] from the next."""

    slack: float
    spacing: float

    def over(self, steps: int) -> float:
        """Over so many rays [px]."""
        return self.slack + STEEPEST * self.spacing * steps


def _torn(chains: list[Chain], active: list[int], ray: int, peaks: list[Peak], room: Room, stride: int) -> list[int]:
    """Chains long enough for a line that meet on `ray`, or part; `peaks` of its candidates, highest first."""
    if len(active) + len(peaks) < 3:
        return []
    long = [c for c in active if chains[c].members * stride >= SHORTEST]
    claims = {c: [p for p in peaks if abs(p[0] - chains[c].tail[1]) <= _reach(chains[c], ray, room)] for c in long}
    met = {c for c in long for d in long if c != d and any(p in claims[d] for p in claims[c])}
    return [c for c in long if c in met or _part(claims[c])]


def _part(peaks: list[Peak]) -> bool:
    """Whether more than one of the `peaks`, highest first, could continue a line."""
    return len(peaks) > 1 and peaks[1][1] >= SLIGHT * peaks[0][1]


def _reach(chain: Chain, ray: int, room: Room) -> float:
    return room.over(ray - chain.tail[0])


def _nearest(chains: list[Chain], active: list[int], ray: int, place: float, room: Room) -> int | None:
    """The active chain whose tail a candidate continues best."""
    best, answer = np.inf, None
    for c in active:
        jump = abs(place - chains[c].tail[1])
        if chains[c].tail[0] < ray and jump <= _reach(chains[c], ray, room) and jump < best:
            best, answer = jump, c
    return answer


def _joined(
    chains: list[Chain], number: NDArray[np.intp], rays: int, room: Room
) -> tuple[list[Chain], NDArray[np.intp]]:
    """Chains that meet where a closed scan begins and ends made one: each ending one with the first that goes on."""
    name = np.arange(len(chains) + 1)
    name[-1] = -1
    taken: set[int] = set()
    for c, ending in enumerate(chains):
        if ending.tail[0] + LONGEST_GAP + 1 < rays:
            continue
        for d, beginning in enumerate(chains):
            steps = beginning.head[0] + rays - ending.tail[0]
            jump = abs(ending.tail[1] - beginning.head[1])
            if d == c or d in taken or steps > LONGEST_GAP + 1 or jump > room.over(steps):
                continue
            beginning.head = (ending.head[0] - rays, ending.head[1])
            beginning.members += ending.members
            ending.members, name[c] = 0, d
            taken.add(d)
            break
    return chains, name[number]

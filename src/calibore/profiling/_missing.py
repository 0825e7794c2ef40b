"""What could not be measured, in words: images refused, stations without images or without a place."""

from collections.abc import Collection, Mapping, Sequence
from itertools import islice, pairwise

import numpy as np

NAMED = 10
"""Stations, or images refused for one reason, that a sentence names."""
REGULAR = 0.8
"""Share of equal steps from which a numbering counts as regular, so that gaps in it are worth a word."""
FEWEST_STEPS = 3
FEW_SHARE = 0.5
"""Fewer takes than elsewhere are worth a word while they are the exception."""


def counted(count: int, noun: str) -> str:
    """`1 image`, `2 images`."""
    return f"{count} {noun}{'s' * (count != 1)}"


def some(things: Sequence[int] | Sequence[str], count: int | None = None) -> str:
    """The first `NAMED` of `things`, of which there are `count`, and how many more."""
    more = (len(things) if count is None else count) - min(len(things), NAMED)
    return ", ".join(map(str, things[:NAMED])) + (f" and {more} more" if more else "")


def refused_sentence(count: int, skipped: Sequence[dict[str, str]]) -> str:
    """`count` images could not be used; `skipped` names them, or the first of them, each with its reason."""
    by_reason: dict[str, list[str]] = {}
    for one in skipped:
        by_reason.setdefault(one["reason"], []).append(one["image"])
    named = [f"{some(names)} ({reason})" for reason, names in by_reason.items()]
    more = [f"{len(named) - NAMED} more reasons in summary.json"] if len(named) > NAMED else []
    return f"{counted(count, 'image')} could not be used: {'; '.join(named[:NAMED] + more)}."


def unlit_sentence(counts: Mapping[int, int]) -> str:
    """The takes of `counts`, each in so many images, show no laser alone and were not looked at."""
    takes, images = sorted(counts), sum(counts.values())
    was = "was" if images == 1 else "were"
    return (
        f"{counted(images, 'image')} {was} not looked at: by laser.takes in the rig file no laser is lit alone in "
        f"take{'s' * (len(takes) > 1)} {some(takes)}."
    )


def unplaced_sentence(stations: Sequence[int]) -> str:
    """`stations` have images, but the motion table does not know them."""
    whose = "whose images were" if len(stations) > 1 else "whose image was"
    return f"motion.table has no row for {counted(len(stations), 'station')}, {whose} left out: {some(stations)}."


def gap_sentences(takes: Sequence[tuple[int, int]], expected: Collection[int] = ()) -> list[str]:
    """Stations and takes that are not there though the others, or `expected`, the motion table, let one expect them.

    `takes`: number of each station seen, ascending, and how many images it has.
    """
    stations, found = [station for station, _ in takes], []
    count, missing = _absent(stations, expected) if expected else _skipped(stations)
    if count:
        why = "motion.table has a row for them" if expected else "the numbering of the others has gaps there"
        found.append(f"{counted(count, 'station')} without an image, but {why}: {some(missing, count)}.")
    most = max((number for _, number in takes), default=0)
    fewer = [station for station, number in takes if number < most]
    if fewer and len(fewer) < FEW_SHARE * len(takes):
        have = "has" if len(fewer) == 1 else "have"
        found.append(f"{counted(len(fewer), 'station')} {have} fewer than the usual {most} takes: {some(fewer)}.")
    return found


def _skipped(stations: Sequence[int]) -> tuple[int, list[int]]:
    """How many numbers a regular numbering leaves out, and the first of them."""
    steps = np.diff(np.array(stations, dtype=np.int64))
    if steps.size < FEWEST_STEPS:
        return 0, []
    usual = int(np.median(steps))
    if (steps == usual).mean() < REGULAR:
        return 0, []
    wide = [(before, after) for before, after in pairwise(stations) if after - before > usual]
    numbers = (number for before, after in wide for number in range(before + usual, after, usual))
    return sum((after - before - 1) // usual for before, after in wide), list(islice(numbers, NAMED))


def _absent(stations: Sequence[int], expected: Collection[int]) -> tuple[int, list[int]]:
    missing = sorted(set(expected) - set(stations))
    return len(missing), missing

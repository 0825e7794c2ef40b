"""From a picture's file to the lines in it, in one call of compiled code that never waits for Python's lock.

The lines are those of the two steps, reading the picture and `detect_ring` or `detect_line`, to the last bit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calibore._native import detect_line_in as line_in_file
from calibore._native import detect_rings_in as rings_in_file
from calibore.stripe._estimators import estimator_named
from calibore.stripe._kernel import as_stripe
from calibore.stripe._picture import CHANNELS
from calibore.stripe._rays import check_annulus, columns, compass, rows
from calibore.stripe._ring import LEAST_RING, RAYS
from calibore.stripe._stripe import Stripe


@dataclass(frozen=True)
class RingPlace:
    """Where a ring is looked for, and in which `channel`: rough `centre` (column, row), radii [px]."""

    centre: tuple[float, float]
    inner: float
    outer: float
    channel: str


def detect_rings_in(
    file: Path, places: Sequence[RingPlace], *, size: tuple[int, int], limit: int, estimator: str = "zero-crossing"
) -> list[Stripe] | None:
    """The ring at each of the `places` in the picture of `file`, of `size` (width, height) and at most `limit` bytes.

    None where anything is in the way, which the two steps say by an exception: no such picture, another size, no ring.
    """
    if any(place.channel not in CHANNELS for place in places):
        return None
    for place in places:
        check_annulus(place.centre, place.inner, place.outer, RAYS)
    where = [(CHANNELS[place.channel], place.centre, (place.inner, place.outer)) for place in places]
    direction, counted = compass(RAYS), np.ones(RAYS, dtype=bool)
    found = rings_in_file(file, size, where, direction, counted, int(estimator_named(estimator)), limit=limit)
    stripes = [as_stripe(direction, *one) for one in found or ()]
    seen = all(np.count_nonzero(stripe.found) >= LEAST_RING * RAYS for stripe in stripes)
    return stripes if found is not None and seen else None


def detect_line_in(
    file: Path,
    *,
    size: tuple[int, int],
    limit: int,
    down: bool = False,
    channel: str = "luma",
    estimator: str = "zero-crossing",
) -> Stripe | None:
    """The line across the picture of `file`, or `down` it, as `detect_line` finds it; None as for `detect_rings_in`."""
    if channel not in CHANNELS:
        return None
    number = int(estimator_named(estimator))
    found = line_in_file(file, size, CHANNELS[channel], number, down, limit=limit)
    return found and as_stripe((rows if down else columns)(size[::-1]).direction, *found)

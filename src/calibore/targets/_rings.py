"""Concentric rings and spokes found in a picture: centre, spokes, rings counted from the inside, every line measured."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.targets._marks import Array, RingMarks
from calibore.targets._rings_chains import Dips, count_rings
from calibore.targets._rings_layout import first_layout
from calibore.targets._rings_passes import Line, measure
from calibore.targets._rings_ridges import find_ridges, vote_for_centre
from calibore.targets._rings_spokes import Spoke, find_spokes

SEEN_ROUND = 0.15
"""A ring counts where dips lie on at least this fraction of the rays."""


def find_rings(image: NDArray[Any], *, rings: int, spokes: int) -> RingMarks:
    """Marks on the rings and spokes of a target in `image` (h, w[, 3]), 8 or 16 bit: dark lines on lighter paper.

    A mark is the midpoint of the two edges of the ink in the picture, as sharp optics would show them: the shift that
    blur gives a curved line is taken away. It is measured across the line; every pixel serves one mark, so that marks
    do not share noise. Rings too close together to be resolved are left out from the outside.

    Raises ImageError: no such target, other numbers of rings or spokes, over-exposed, blurred, cut off.
    """
    plane = _brightness(image)
    ridges = find_ridges(plane)
    centre = vote_for_centre(ridges)
    if centre is None:
        raise ImageError("No ring target was found.")
    found = find_spokes(ridges, centre)
    if len(found) != spokes:
        raise ImageError(f"{len(found)} spokes were found, {spokes} are stated.")
    dips = count_rings(plane, found[0].centre, found)
    lines, layout = measure(plane, first_layout(dips, found[0].centre, found, _ring_count(dips, rings)))
    return _marks(lines, layout.centre)


def _brightness(image: NDArray[Any]) -> Array:
    """The picture (h, w) as fractions of full scale."""
    white = np.iinfo(image.dtype).max
    return (image if image.ndim == 2 else image[..., :3].mean(axis=2)) / float(white)


def _ring_count(dips: Dips, stated: int) -> int:
    rays = np.bincount(dips.ring, minlength=stated + 2)
    seen = rays >= SEEN_ROUND * dips.azimuths.size
    return int(np.argmin(np.append(seen[1 : stated + 1], False)))


def _marks(lines: list[Line], centre: Array) -> RingMarks:
    place, direction = (np.concatenate([getattr(line, name) for line in lines]) for name in ("place", "direction"))
    sigma, width = (np.concatenate([getattr(line, name) for line in lines]) for name in ("sigma", "width"))
    ring, spoke = (
        np.concatenate([np.full(line.sigma.size, getattr(line, name), dtype=np.intp) for line in lines])
        for name in ("ring", "spoke")
    )
    return RingMarks(
        place[:, 0], place[:, 1], direction, sigma, ring, spoke, (float(centre[0]), float(centre[1])), width
    )

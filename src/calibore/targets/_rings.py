"""Concentric rings and spokes found in a picture: the spokes, the rings counted from the inside, each line measured."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Array, RingMarks
from calibore.targets._rings_chains import count_rings
from calibore.targets._rings_checks import chosen_spokes, counted_rings, picture_of_target
from calibore.targets._rings_layout import first_layout
from calibore.targets._rings_passes import Line, measure
from calibore.targets._rings_ridges import find_ridges, likely_centres
from calibore.targets._rings_spokes import find_spokes


def find_rings(image: NDArray[Any], *, rings: int, spokes: int) -> RingMarks:
    """Marks on the rings and spokes of a target in `image` (h, w[, 3]), 8 or 16 bit: dark lines on lighter paper.

    A mark is the midpoint of the two edges of the ink in the picture, as sharp optics would show them: the shift that
    blur gives a curved line is taken away. It is measured across the line; every pixel serves one mark, so that marks
    do not share noise. Rings too close together to be resolved are left out from the outside.

    Raises ImageError: no such target, other numbers of rings or spokes, over-exposed, blurred, cut off.
    """
    plane = picture_of_target(image)
    size = plane.shape[1], plane.shape[0]
    ridges = find_ridges(plane)
    found = chosen_spokes((find_spokes(ridges, centre) for centre in likely_centres(ridges)), size, spokes)
    dips = count_rings(plane, found[0].centre, found)
    count = counted_rings(dips, rings)
    lines, layout = measure(plane, first_layout(dips, found[0].centre, found, count))
    return _marks(lines, layout.meeting)


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

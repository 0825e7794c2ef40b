"""Concentric rings and spokes found in a picture: the spokes, the rings counted from the inside, each line measured."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.targets._marks import RingMarks
from calibore.targets._rings_chains import count_rings
from calibore.targets._rings_checks import FEWEST_RINGS, chosen_spokes, counted_rings, picture_of_target
from calibore.targets._rings_layout import Layout, first_layout
from calibore.targets._rings_passes import Line, measure
from calibore.targets._rings_ridges import find_ridges, likely_centres
from calibore.targets._rings_spokes import find_spokes

RESOLVED = 0.6
"""Of the rings that are counted, at least this fraction must be measured, or the picture is blurred."""


def find_rings(image: NDArray[Any], *, rings: int, spokes: int) -> RingMarks:
    """Marks on the rings and spokes of a target in `image` (h, w[, 3]), 8 or 16 bit: dark lines on lighter paper.

    A mark is the midpoint of the two edges of the ink in the picture, as sharp optics would show them: what blur shifts
    on a curved line and in uneven light is taken away. (Where the lens stretches unevenly, this is not the image of
    the ink's midline.) It is measured across the line. Every pixel serves one mark: marks do not share noise.
    Rings closer together than `APART` blurs are not resolved and left out, from the inside of any place outwards.

    Raises ImageError: no such target, other numbers of rings or spokes, over-exposed, blurred, cut off.
    """
    plane = picture_of_target(image)
    size = plane.shape[1], plane.shape[0]
    ridges = find_ridges(plane)
    found = chosen_spokes((find_spokes(ridges, centre) for centre in likely_centres(ridges)), size, spokes)
    dips = count_rings(plane, found[0].centre, found)
    count = counted_rings(dips, rings)
    lines, layout = measure(plane, first_layout(dips, found[0].centre, found, count))
    _refuse_blurred(lines, layout, count)
    return _marks(lines, layout, rings)


def _refuse_blurred(lines: list[Line], layout: Layout, counted: int) -> None:
    measured = sum(line.ring > 0 for line in lines)
    if measured < max(min(FEWEST_RINGS, counted), RESOLVED * counted):
        raise ImageError(
            f"Only {measured} of {counted} rings are resolved with a blur of {layout.blur:.1f} px; focus on the target "
            "or photograph it with more pixels or from nearer."
        )


def _marks(lines: list[Line], layout: Layout, stated: int) -> RingMarks:
    place, direction, sigma, width = (
        np.concatenate([getattr(line, name) for line in lines]) for name in ("place", "direction", "sigma", "width")
    )
    ring, spoke = (
        np.concatenate([np.full(line.sigma.size, getattr(line, name), dtype=np.intp) for line in lines])
        for name in ("ring", "spoke")
    )
    measured = {line.ring for line in lines if line.ring}
    centre = float(layout.meeting[0]), float(layout.meeting[1])
    return RingMarks(
        place[:, 0], place[:, 1], direction, sigma, ring, spoke, centre, width, _left_out(measured, stated)
    )


def _left_out(measured: set[int], stated: int) -> str:
    missing = [str(ring) for ring in range(1, stated + 1) if ring not in measured]
    if not missing:
        return ""
    which = f"Ring {missing[0]} was" if len(missing) == 1 else f"Rings {', '.join(missing)} were"
    return f"{which} not measured: not in the picture, not resolved, or too near the paper's edge."

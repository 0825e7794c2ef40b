"""All rings and spokes measured, twice: from the lines found first noise, curves and widths are learnt."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._rings_curves import refitted
from calibore.targets._rings_layout import Layout, Ring, smooth_radius, smooth_width
from calibore.targets._rings_lines import BROAD, Line, ring_line, spoke_line
from calibore.targets._rings_noise import Noise, learn_noise
from calibore.targets._rings_spokes import meeting_of

Array = NDArray[Any]

PASSES = 2
FIRST_RINGS = (1, 2)
WIDTH_POWERS = 2
"""Of a spoke's ink width along it."""
WORST_MISFIT = 5.0
"""Chi-square per degree of freedom of a line, relative to that of most lines, beyond which it shows something else."""
RELATIVE_NOISE = 1e-4
"""First guess: variance of a pixel relative to its brightness (shot noise) and to full scale."""


def measure(plane: Array, layout: Layout) -> tuple[list[Line], Layout]:
    """All lines of a picture (h, w) with values 0 to 1, and the layout they show."""
    noise = Noise(RELATIVE_NOISE * 0.02, RELATIVE_NOISE)
    layout = _first_look(plane, layout, noise)
    lines: list[Line] = []
    for _ in range(PASSES):
        lines = _all_lines(plane, layout, noise)
        if not lines:
            break
        predicted, square = (
            np.concatenate([getattr(line.bars, name) for line in lines]) for name in ("predicted", "square")
        )
        noise = learn_noise(predicted, square)
        layout = _renewed(layout, lines)
    return lines, layout


def _first_look(plane: Array, layout: Layout, noise: Noise) -> Layout:
    """The layout with blur and contrast of its innermost rings, whose lines are the broadest."""
    looks = [ring_line(plane, layout, number, noise) for number in FIRST_RINGS if number <= len(layout.rings)]
    seen = [line for line in looks if line is not None]
    if not seen:
        return layout
    blur, contrast = (float(np.mean([getattr(line.bars, name) for line in seen])) for name in ("blur", "contrast"))
    return replace(layout, blur=blur, contrast=contrast, blur_known=True)


def _all_lines(plane: Array, layout: Layout, noise: Noise) -> list[Line]:
    lines = [ring_line(plane, layout, number, noise) for number in range(1, len(layout.rings) + 1)]
    lines += [spoke_line(plane, layout, number, noise) for number in range(len(layout.spokes))]
    found = [line for line in lines if line is not None]
    misfit = [float(np.median(line.bars.misfit)) for line in found]
    usual = float(np.median(misfit)) if misfit else 0.0
    return [line for line, own in zip(found, misfit, strict=True) if own < WORST_MISFIT * usual]


def _renewed(layout: Layout, lines: list[Line]) -> Layout:
    """The layout as measured: curves and widths of the lines, blur, contrast, and where the spokes meet."""
    rings, spokes, widths = list(layout.rings), list(layout.spokes), list(layout.spoke_widths)
    for line in lines:
        if line.ring:
            ring = rings[line.ring - 1]
            azimuth, radius = layout.polar(*line.place.T)
            curve, width = smooth_radius(azimuth, radius, before=ring), smooth_width(azimuth, line.width)
            rings[line.ring - 1] = Ring(curve, width, ring.seen)
        else:
            spokes[line.spoke] = refitted(spokes[line.spoke], line.place, line.sigma, meeting=layout.meeting)
            distance, _ = spokes[line.spoke].coordinates(line.place)
            widths[line.spoke] = np.polynomial.polynomial.polyfit(distance, line.width, WIDTH_POWERS)
    measured = tuple(spokes[line.spoke] for line in lines if line.spoke >= 0)
    blur = float(np.median([line.bars.blur for line in lines]))
    broad = [line.bars.contrast for line in lines if np.median(line.width) > BROAD * line.bars.blur]
    return replace(
        layout,
        rings=tuple(rings),
        spokes=tuple(spokes),
        spoke_widths=tuple(widths),
        meeting=meeting_of(measured) if len(measured) > 1 else layout.meeting,
        blur=blur,
        blur_known=True,
        contrast=float(np.median(broad)) if broad else layout.contrast,
    )

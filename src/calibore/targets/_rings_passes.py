"""Every ring and spoke measured: windows that hold one line only, noise learnt, curves drawn through what was found."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Array
from calibore.targets._rings_bars import Bars, Noise, Start, fit_bars, learn_noise
from calibore.targets._rings_curves import Curve, harmonics, refitted, ring_curve, spoke_curve
from calibore.targets._rings_layout import CLEAR, NARROWEST, Layout, Ring, smooth_radius, smooth_width
from calibore.targets._rings_spokes import meeting_of
from calibore.targets._rings_strips import Strip, strip_along

PASSES = 2
FIRST_RINGS = (1, 2)
LEAST_STEP, MOST_BINS = 2.0, 1000
"""px of a line that one mark stands for, at least; marks of the longest ring, at most."""
BROAD = 2.6
"""Blurs of ink width from which a line's own contrast can be told from its width."""
CONTRAST_SIGMA, SAME_INK = 0.3, 0.004
"""Standard uncertainty of the ink's contrast before it is known, and from line to line."""
LIGHT_WAVES, LIGHT_POWERS, WIDTH_POWERS = 4, 3, 2
"""Harmonics along a ring and powers along a spoke of the slope of the light; powers of a spoke's ink width."""
FAINT = 0.3
"""A bin whose ink is narrower than this fraction of what was expected shows no line."""
WORST_MISFIT = 4.0
"""Chi-square per degree of freedom, relative to the line's median."""
BESIDE, FARTHEST_OFF, ROUGHNESS = 9, 6.0, 0.02
"""A place so many standard deviations and px off the median of the bins beside it is no mark."""
LARGEST = 2.0
"""Blurs from the expected curve to a place that can be the line's."""
FEWEST_BINS = 12
RELATIVE_NOISE = 1e-4
"""First guess: variance of a pixel relative to its brightness (shot noise) and to full scale."""


@dataclass(frozen=True, eq=False)
class Line:
    """What was measured of one ring (`ring` > 0) or spoke (`spoke` >= 0): `place` (b, 2) [px] of the ink's midpoint,
    unit `direction` (b, 2) in which it was measured, `sigma`, `width` (b,) [px] of its good bins, and the fit's `bars`.
    """

    ring: int
    spoke: int
    place: Array
    direction: Array
    sigma: Array
    width: Array
    bars: Bars


def measure(plane: Array, layout: Layout) -> tuple[list[Line], Layout]:
    """All lines of a picture (h, w) with values 0 to 1, and the layout they show."""
    noise = Noise(RELATIVE_NOISE * 0.02, RELATIVE_NOISE)
    layout = _first_look(plane, layout, noise)
    lines: list[Line] = []
    for _ in range(PASSES):
        lines = _all_lines(plane, layout, noise)
        noise = learn_noise([line.bars for line in lines])
        layout = _renewed(layout, lines)
    return lines, layout


def _first_look(plane: Array, layout: Layout, noise: Noise) -> Layout:
    """The layout with blur and contrast of its innermost rings, whose lines are the broadest."""
    looks = [
        _ring_line(plane, layout, number, noise, _step(layout)) for number in FIRST_RINGS if number <= len(layout.rings)
    ]
    seen = [line for line in looks if line is not None]
    if not seen:
        return layout
    blur, contrast = (float(np.mean([getattr(line.bars, name) for line in seen])) for name in ("blur", "contrast"))
    return replace(layout, blur=blur, contrast=contrast)


def _step(layout: Layout) -> float:
    """Length [px] of the bins."""
    return max(LEAST_STEP, 2 * np.pi * layout.rings[-1].radius.coefficients[0] / MOST_BINS)


def _all_lines(plane: Array, layout: Layout, noise: Noise) -> list[Line]:
    step = _step(layout)
    lines: list[Line | None] = [
        _ring_line(plane, layout, number, noise, step) for number in range(1, len(layout.rings) + 1)
    ]
    lines += [_spoke_line(plane, layout, number, noise, step) for number in range(len(layout.spokes))]
    return [line for line in lines if line is not None]


def _ring_line(plane: Array, layout: Layout, number: int, noise: Noise, step: float) -> Line | None:
    ring = layout.rings[number - 1]
    curve = ring_curve(layout.centre, ring.radius)
    free, resolved = layout.room(number, curve.parameter)
    width = np.maximum(ring.width(curve.parameter), NARROWEST)
    half = np.where(resolved & layout.seen(number, curve.parameter), layout.half_window(width, free), 0.0)
    if (half > 0).sum() * curve.length < FEWEST_BINS * step * half.size:
        return None

    def usable(u: Array, v: Array, index: Array) -> NDArray[np.bool_]:
        azimuth, radius = _polar(u, v, layout.centre)
        return layout.beside_spokes(azimuth, radius)

    strip = strip_along(plane, curve, half, step=step, usable=usable)
    along = harmonics(curve.parameter_at(strip.middle), LIGHT_WAVES)
    return _fitted(strip, curve, along, width, layout, noise, ring=number)


def _spoke_line(plane: Array, layout: Layout, number: int, noise: Noise, step: float) -> Line | None:
    spoke = layout.spokes[number]
    apart = _angle_to_neighbours(layout, number)
    ink = float(np.polynomial.polynomial.polyval(0.0, layout.spoke_widths[number]))
    first = (ink + (CLEAR + 4) * layout.blur + 1) / apart
    last = min(spoke.length, max(_outermost(layout, spoke.azimuth), first + 1))
    if last - first < FEWEST_BINS * step:
        return None
    curve = spoke_curve(spoke, first, last)
    width = np.maximum(np.polynomial.polynomial.polyval(curve.parameter, layout.spoke_widths[number]), NARROWEST)
    half = layout.half_window(width, curve.parameter * apart - width / 2 - CLEAR * layout.blur)

    def usable(u: Array, v: Array, index: Array) -> NDArray[np.bool_]:
        return layout.between_rings(*_polar(u, v, layout.centre))

    strip = strip_along(plane, curve, half, step=step, usable=usable)
    part = (strip.middle / len(half) * 2 - 1)[:, None]
    return _fitted(strip, curve, part ** np.arange(LIGHT_POWERS + 1), width, layout, noise, spoke=number)


def _fitted(
    strip: Strip,
    curve: Curve,
    along: Array,
    width: Array,
    layout: Layout,
    noise: Noise,
    *,
    ring: int = 0,
    spoke: int = -1,
) -> Line | None:
    """The line's marks, moved from where blur has shifted a curved line to where its ink is."""
    if strip.starts.size < FEWEST_BINS:
        return None
    expected = curve.at(width, strip.middle)
    broad = float(np.median(expected)) > BROAD * layout.blur
    start = Start(expected, layout.blur, layout.contrast, CONTRAST_SIGMA if broad else SAME_INK)
    bars = fit_bars(strip, along, start, noise)
    shift = bars.blur**2 * (curve.at(curve.bend, strip.middle) / 2 + along @ bars.slope)
    direction = curve.at(curve.normal, strip.middle)
    direction /= np.hypot(*direction.T)[:, None]
    place = curve.at(curve.point, strip.middle) + (bars.place + shift)[:, None] * direction
    good = _good(bars, expected)
    if good.sum() < FEWEST_BINS:
        return None
    return Line(ring, spoke, place[good], direction[good], bars.sigma[good], bars.width[good], bars)


def _good(bars: Bars, expected: Array) -> NDArray[np.bool_]:
    """Bins (b,) whose pixels show the line and nothing else, at a place like that of the bins beside them."""
    from scipy.ndimage import median_filter

    off = np.abs(bars.place - median_filter(bars.place, size=BESIDE, mode="nearest"))
    good = (bars.width > FAINT * expected) & (bars.misfit < WORST_MISFIT * np.median(bars.misfit))
    return good & (off < FARTHEST_OFF * bars.sigma + ROUGHNESS) & (np.abs(bars.place) < LARGEST * bars.blur)


def _renewed(layout: Layout, lines: list[Line]) -> Layout:
    """The layout as measured: curves and widths of the lines, blur, contrast, and where the spokes meet."""
    rings, spokes, widths = list(layout.rings), list(layout.spokes), list(layout.spoke_widths)
    for line in lines:
        if line.ring:
            azimuth, radius = _polar(*line.place.T, layout.centre)
            radius, width = smooth_radius(azimuth, radius), smooth_width(azimuth, line.width)
            rings[line.ring - 1] = Ring(radius, width, rings[line.ring - 1].seen)
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
        contrast=float(np.median(broad)) if broad else layout.contrast,
    )


def _polar(u: Array, v: Array, centre: Array) -> tuple[Array, Array]:
    return np.arctan2(v - centre[1], u - centre[0]) % (2 * np.pi), np.hypot(u - centre[0], v - centre[1])


def _angle_to_neighbours(layout: Layout, number: int) -> float:
    """Angle [rad] from a spoke to the nearer one beside it."""
    azimuths = np.array([spoke.azimuth for spoke in layout.spokes])
    turn = np.abs((azimuths - azimuths[number] + np.pi) % (2 * np.pi) - np.pi)
    return float(np.sort(turn)[1])


def _outermost(layout: Layout, azimuth: float) -> float:
    """Radius [px] of the outermost ring seen beside an azimuth."""
    beside = np.array([azimuth - 0.1, azimuth + 0.1]) % (2 * np.pi)
    radii = [
        ring.radius(beside).min() for number, ring in enumerate(layout.rings, 1) if layout.seen(number, beside).any()
    ]
    return float(max(radii, default=0.0))

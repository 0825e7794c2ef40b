"""One ring or spoke measured: the window that holds this line only, its bars fitted, what of them are marks."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._rings_bars import Bars, Start, fit_bars
from calibore.targets._rings_curves import Curve, harmonics, ring_curve, spoke_curve
from calibore.targets._rings_layout import CLEAR, NARROWEST, Layout
from calibore.targets._rings_noise import Noise
from calibore.targets._rings_strips import Strip, strip_along

Array = NDArray[Any]

LEAST_STEP, MOST_BINS, FEW_BINS = 2.0, 1000, 300
"""px of a line that one mark stands for, at least; marks of the longest ring, at most; of a short ring, if they fit."""
FEWEST_BINS = 12
BROAD = 2.6
"""Blurs of ink width from which a line's own contrast can be told from its width."""
CONTRAST_SIGMA = (0.004, 0.03, 0.3)
"""Standard uncertainty of the ink's contrast: of narrow lines, which must take it from others, of broad lines, and
before it is known.
"""
BLUR_SIGMA, SAME_BLUR = 0.5, 0.05
"""Relative standard uncertainty of the blur before it is known, and from line to line: a line along the pixels' rows
hardly tells its blur from its width.
"""
LIGHT_WAVES, LIGHT_POWERS = 4, 3
"""Harmonics along a ring, powers along a spoke, of the slope of the light."""
FAINT = 0.4
"""A bin whose ink is narrower than this fraction of what was expected shows no line."""
WORST_MISFIT = 4.0
"""Chi-square per degree of freedom, relative to the line's median."""
BESIDE, FARTHEST_OFF, ROUGHNESS = 9, 6.0, 0.02
"""A place so many standard deviations and px off the median of the bins beside it is no mark."""
LARGEST, UNSURE = 2.0, 0.1
"""Blurs from the expected curve to a place that can be the line's; standard uncertainty [blurs] of what is no mark."""
BEHIND = 0.1
"""rad beside a spoke where it is seen how far out rings reach."""


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


def ring_line(plane: Array, layout: Layout, number: int, noise: Noise) -> Line | None:
    """Ring `number` (from 1) in a picture (h, w), None where too little of it can be measured alone."""
    ring, step = layout.rings[number - 1], bin_length(layout, number)
    curve = ring_curve(layout.centre, ring.radius)
    free, resolved = layout.room(number, curve.parameter)
    width = np.maximum(ring.width(curve.parameter), NARROWEST)
    half = np.where(resolved & layout.seen(number, curve.parameter), layout.half_window(width, free), 0.0)
    if (half > 0).sum() * curve.length < FEWEST_BINS * step * half.size:
        return None

    def usable(u: Array, v: Array) -> NDArray[np.bool_]:
        return layout.beside_spokes(*layout.polar(u, v))

    strip = strip_along(plane, curve, half, step=step, usable=usable)
    along = harmonics(curve.parameter_at(strip.middle), LIGHT_WAVES)
    return _fitted(strip, curve, along, width, layout, noise, ring=number)


def spoke_line(plane: Array, layout: Layout, number: int, noise: Noise) -> Line | None:
    """Spoke `number` (from 0), from where the spokes have parted to the outermost ring beside it."""
    spoke, step = layout.spokes[number], bin_length(layout)
    apart = _angle_to_neighbours(layout, number)
    ink = float(layout.spoke_widths[number][0])
    first = (ink + (CLEAR + 4) * layout.blur + 1) / apart
    last = min(spoke.length, _outermost(layout, spoke.azimuth))
    if last - first < FEWEST_BINS * step:
        return None
    curve = spoke_curve(spoke, first, last)
    width = np.maximum(np.polynomial.polynomial.polyval(curve.parameter, layout.spoke_widths[number]), NARROWEST)
    half = layout.half_window(width, curve.parameter * apart - width / 2 - CLEAR * layout.blur)

    def usable(u: Array, v: Array) -> NDArray[np.bool_]:
        return layout.between_rings(*layout.polar(u, v))

    strip = strip_along(plane, curve, half, step=step, usable=usable)
    part = (strip.middle / len(half) * 2 - 1)[:, None]
    return _fitted(strip, curve, part ** np.arange(LIGHT_POWERS + 1), width, layout, noise, spoke=number)


def bin_length(layout: Layout, number: int | None = None) -> float:
    """Length [px] of the bins of a ring, or of the spokes."""
    longest = 2 * np.pi * float(layout.rings[-1].radius.coefficients[0])
    own = longest if number is None else 2 * np.pi * float(layout.rings[number - 1].radius.coefficients[0])
    return max(LEAST_STEP, min(longest / MOST_BINS, own / FEW_BINS))


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
    blur_sigma = layout.blur * (SAME_BLUR if layout.blur_known else BLUR_SIGMA)
    contrast_sigma = CONTRAST_SIGMA[0 if not broad else 1 if layout.blur_known else 2]
    start = Start(expected, layout.blur, blur_sigma, layout.contrast, contrast_sigma)
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
    good &= (off < FARTHEST_OFF * bars.sigma + ROUGHNESS) & (np.abs(bars.place) < LARGEST * bars.blur)
    return good & (bars.sigma < UNSURE * bars.blur)


def _angle_to_neighbours(layout: Layout, number: int) -> float:
    """Angle [rad] from a spoke to the nearer one beside it."""
    azimuths = np.array([spoke.azimuth for spoke in layout.spokes])
    turn = np.abs((azimuths - azimuths[number] + np.pi) % (2 * np.pi) - np.pi)
    return float(np.sort(turn)[1])


def _outermost(layout: Layout, azimuth: float) -> float:
    """Radius [px] of the outermost ring seen beside an azimuth."""
    beside = np.array([azimuth - BEHIND, azimuth + BEHIND]) % (2 * np.pi)
    radii = [
        ring.radius(beside).min() for number, ring in enumerate(layout.rings, 1) if layout.seen(number, beside).any()
    ]
    return float(max(radii, default=0.0))

"""What is known of a target's rings and spokes in a picture, and so what room there is to measure each line alone."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._rings_curves import HARMONICS, Round, fit_round
from calibore.targets._rings_dips import Dips
from calibore.targets._rings_spokes import Spoke

Array = NDArray[Any]

APART = 5.5
"""Blurs between neighbouring rings; nearer ones are not resolved."""
CLEAR = 3.2
"""Blurs from the edge of a line to where it is not seen any more."""
LEAST_ROOM = 2.0
"""Blurs beyond the ink's edge, on both sides, that must be free of other lines."""
MARGIN = 1.5
"""px of paper beside a line, to know its brightness."""
LIKELY_BLUR = 1.5
"""px, at most, to begin with; broad lines do not tell."""
USUAL_CONTRAST = 0.85
SATURATED_DEPTH = 0.7
"""Dips deeper than this fraction of the ink's contrast are as wide as the ink, shallower ones as wide as the blur."""
WIDTH_WAVES, WIDTH_STIFFNESS = 6, 1e-3
FWHM = 2.355
"""Full width at half depth of a Gaussian, in standard deviations."""
LEAST_HARMONICS, HARMONICS_PER_PIXEL = 4, 0.12
"""A small ring has fewer: its curvature, by which blur moves it, must not follow noise."""
FORMER, EVERY = 0.08, 4
"""Weight of where a ring was seen against where it was measured; of so many rays one is asked."""
STRAYED = 2.0
"""px: dips farther off the smooth curve of their ring belong to something else."""
NARROWEST = 0.02
"""px"""


@dataclass(frozen=True, eq=False)
class Ring:
    """`radius` [px] and ink `width` [px] round the azimuth, and the rays (n,) on which the ring was seen."""

    radius: Round
    width: Round
    seen: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Layout:
    """Rings from 1 outwards round the `centre` (2,) [px], spokes and their ink widths (constant, linear, ...) [px],
    `meeting` (2,) of the spokes as measured, `blur` [px], ink `contrast`; `paper` (rays,) [px]: where rays leave it;
    `blur_known`: measured, not guessed.
    """

    centre: Array
    meeting: Array
    rings: tuple[Ring, ...]
    spokes: tuple[Spoke, ...]
    spoke_widths: tuple[Array, ...]
    blur: float
    contrast: float
    paper: Array
    blur_known: bool = False

    def polar(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Azimuth (n,) [rad] from 0 to 2 pi and radius (n,) [px] round the centre."""
        x, y = u - self.centre[0], v - self.centre[1]
        return np.arctan2(y, x) % (2 * np.pi), np.hypot(x, y)

    def seen(self, number: int, azimuth: Array) -> NDArray[np.bool_]:
        """Whether ring `number` (from 1) was seen near the azimuths (n,)."""
        seen = self.rings[number - 1].seen
        return seen[np.rint(azimuth / (2 * np.pi) * seen.size).astype(np.intp) % seen.size]

    def room(self, number: int, azimuth: Array) -> tuple[Array, Array]:
        """How far (n,) [px] from the midline of a ring the picture shows nothing else; whether it is resolved."""
        radius, slope, _ = self.rings[number - 1].radius.derivatives(azimuth)
        upright = radius / np.hypot(radius, slope)
        inner = radius - self._radius(number - 1, azimuth)
        outer = self._radius(number + 1, azimuth) - radius
        before = radius - inner - self._radius(number - 2, azimuth) if number > 1 else inner
        unseen = inner * np.nan_to_num(np.clip(inner / before, 0.3, 1.0), nan=1.0)
        gap = np.fmin(inner, np.where(np.isfinite(outer), outer, unseen))
        width = np.maximum(self.rings[number - 1].width(azimuth), NARROWEST)
        clear = gap - width / 2 - CLEAR * self.blur
        free = np.minimum(clear, self._paper(azimuth) - radius - CLEAR * self.blur) * upright
        return np.nan_to_num(free), gap * upright > APART * self.blur + width

    def half_window(self, width: Array, free: Array) -> Array:
        """Half (n,) [px] of the window across a line of ink `width` with `free` room; 0 where there is too little."""
        half = np.cbrt(width**3 + (FWHM * self.blur) ** 3) / 2 + (4 - FWHM / 2) * self.blur + MARGIN
        half = np.minimum(half, free)
        return np.where(half > width / 2 + LEAST_ROOM * self.blur, half, 0.0)

    def _radius(self, number: int, azimuth: Array) -> Array:
        """Radius (n,) of a ring where it was seen, NaN elsewhere; 0 for the centre and inside it."""
        if number < 1:
            return np.zeros(azimuth.shape)
        if number > len(self.rings):
            return np.full(azimuth.shape, np.nan)
        return np.where(self.seen(number, azimuth), self.rings[number - 1].radius(azimuth), np.nan)

    def _paper(self, azimuth: Array) -> Array:
        """Where (n,) [px] a ray leaves the paper, or one beside it."""
        ray = np.rint(azimuth / (2 * np.pi) * self.paper.size).astype(np.intp)
        return np.min([self.paper[(ray + beside) % self.paper.size] for beside in (-1, 0, 1)], axis=0)

    def beside_spokes(self, azimuth: Array, radius: Array) -> NDArray[np.bool_]:
        """Whether places lie so far from all spokes that these are not seen there."""
        free = np.ones(radius.shape, dtype=bool)
        for spoke, width in zip(self.spokes, self.spoke_widths, strict=True):
            turn = azimuth - spoke.azimuth
            along, across = radius * np.cos(turn), radius * np.sin(turn)
            ink = np.maximum(np.polynomial.polynomial.polyval(along, width), NARROWEST)
            free &= (along < 0) | (np.abs(across - spoke.offset(along)) > ink / 2 + CLEAR * self.blur + 0.5)
        return free

    def between_rings(self, azimuth: Array, radius: Array) -> NDArray[np.bool_]:
        """Whether places lie so far from all rings that these are not seen there."""
        free = np.ones(radius.shape, dtype=bool)
        for ring in self.rings:
            clear = np.maximum(ring.width(azimuth), NARROWEST) / 2 + CLEAR * self.blur + 0.5
            free &= np.abs(radius - ring.radius(azimuth)) > clear
        return free


def first_layout(dips: Dips, centre: Array, spokes: tuple[Spoke, ...], count: int) -> Layout:
    """The layout that the dips of `count` rings show."""
    narrowest = min(float(np.median(dips.width[dips.ring == ring])) for ring in range(1, count + 1))
    blur = min(narrowest / FWHM, LIKELY_BLUR)
    rings = tuple(_ring(dips, number, blur) for number in range(1, count + 1))
    widest = max(float(rings[0].width(dips.azimuths).max()), NARROWEST) * 1.15
    widths = tuple(np.array([widest]) for _ in spokes)
    return Layout(centre, centre, rings, spokes, widths, blur, USUAL_CONTRAST, dips.paper)


def _ring(dips: Dips, number: int, blur: float) -> Ring:
    from scipy.special import erfinv

    member = dips.ring == number
    azimuth = dips.azimuths[dips.ray[member]]
    part = dips.depth[member] / USUAL_CONTRAST
    shallow = 2 * np.sqrt(2) * blur * erfinv(np.minimum(part, SATURATED_DEPTH))
    width = np.where(part < SATURATED_DEPTH, shallow, np.maximum(dips.width[member], shallow))
    radius = smooth_radius(azimuth, dips.radius[member])
    seen = np.zeros(dips.azimuths.size, dtype=bool)
    seen[dips.ray[member][np.abs(dips.radius[member] - radius(azimuth)) < STRAYED]] = True
    return Ring(radius, smooth_width(azimuth, width), seen)


def smooth_radius(azimuth: Array, radius: Array, *, before: Ring | None = None) -> Round:
    """The curve of a ring through its marks, and where it has none but was seen, near where it was `before`."""
    count = min(HARMONICS, int(LEAST_HARMONICS + HARMONICS_PER_PIXEL * np.median(radius)))
    if before is None:
        return fit_round(azimuth, radius, count=min(count, max(2, azimuth.size // 3)))
    seen = np.flatnonzero(before.seen)[::EVERY] * (2 * np.pi / before.seen.size)
    weight = np.repeat([1.0, FORMER], [azimuth.size, seen.size])
    return fit_round(np.append(azimuth, seen), np.append(radius, before.radius(seen)), weight=weight, count=count)


def smooth_width(azimuth: Array, width: Array) -> Round:
    return fit_round(azimuth, width, count=WIDTH_WAVES, stiffness=WIDTH_STIFFNESS)

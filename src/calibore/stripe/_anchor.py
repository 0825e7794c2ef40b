"""Where a line that is no Gaussian has its place: nearer to where it is brightest, as `native/src/stripe/anchor.rs`.

Speckle makes the faint flanks of a line as telling as its top. Where one flank is longer, as on a sloping wall, a fit
that trusts them lies beside the top. The first look sees little of the flanks: what the second differs from it on all
of the line, beyond doubt, is no noise but the shape of the line, and half of it is taken back.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._noise import NORMAL

Array = NDArray[np.float64]
BLOCK, SHORTEST_BLOCK = 12.0, 8
"""Line widths along the line, at least so many rays, whose places are averaged: such means are independent ..."""
FEWEST_BLOCKS = 8
"""... and so many are needed."""
CERTAIN = 4.0
"""Standard deviations by which a difference of all of the line is beyond doubt; and it must be larger than what differs
from piece to piece, for dirt makes pieces of a line skewed."""
HALF = 0.5
"""Of a line with one longer flank the first look is right, of one that lies half on dirt the second: between them."""
ASTRAY = 6.0
"""Standard deviations by which the looks may differ on one ray: more is no noise, but light that is not the line's."""
OF_MEDIAN = 1.2533
"""Standard deviation of a median over that of a mean."""


@dataclass(frozen=True)
class Anchor:
    """How far the first look lies `aside` of the second on all of the line [px]; how many standard uncertainties it may
    be `astray` on one ray, for where the line is wide or faint both looks are less sure.
    """

    aside: float
    astray: float


def anchor(
    first: Array,
    second: Array,
    calm: NDArray[np.bool_],
    u: Array,
    hidden: NDArray[np.bool_],
    *,
    width: float,
    spacing: float,
) -> Anchor:
    """From the places `first` and `second` (n,) [px], NaN where there is none, the latter of standard uncertainty `u`,
    of the rays that are `calm` (n,); where the top is `hidden` (n,) no look has seen it.
    """
    differs = np.where(calm, first - second, np.nan)
    off = np.where(hidden, np.nan, differs)
    block = max(int(BLOCK * width / spacing), SHORTEST_BLOCK)
    pieces = [off[begin : begin + block] for begin in range(0, off.size, block)]
    pieces = [piece[np.isfinite(piece)] for piece in pieces]
    means = np.array([piece.mean() for piece in pieces if 2 * piece.size >= block])
    if means.size < FEWEST_BLOCKS:
        known = differs[np.isfinite(differs)]
        return Anchor(0.0, _astray(differs, u, float(np.median(known))) if hidden.any() and known.size else np.inf)
    middle = float(np.median(means))
    doubt = _about(means, middle) * max(CERTAIN * OF_MEDIAN / np.sqrt(means.size), 1.0)
    part = max(1 - (doubt / middle) ** 2, 0.0) if middle else 0.0
    return Anchor(HALF * middle * part, _astray(differs, u, middle))


def _about(values: Array, middle: float) -> float:
    """Robust standard deviation of `values` (n,) about `middle`."""
    return NORMAL * float(np.median(np.abs(values - middle)))


def _astray(off: Array, u: Array, middle: float) -> float:
    """Standard uncertainties `u` (n,) by which places may be `off` (n,) from the `middle`."""
    return ASTRAY * NORMAL * float(np.nanmedian(np.abs(off - middle) / u))

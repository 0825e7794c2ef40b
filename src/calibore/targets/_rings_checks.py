"""Pictures that cannot be used, and why: exposure, sharpness, what of the target is seen, what contradicts itself."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.targets._marks import Array
from calibore.targets._rings_dips import Dips
from calibore.targets._rings_spokes import Spoke

SMALLEST = 200
"""px: the shorter side of a picture that can show a target."""
SATURATED = 0.02
"""Fraction of the bright pixels that may be at full scale."""
DARKEST = 0.12
"""Of full scale: the brightest hundredth of the picture must be brighter."""
FULL_SCALES = (255, 1023, 4095, 16383, 65535)
"""Of sensors with 8, 10, 12, 14 and 16 bit."""
SEEN = 0.15
"""A ring counts where it was seen on this fraction of the rays."""
FEWEST_RINGS = 3
WHOLE = 0.6
"""The innermost rings must be seen on this fraction of their way round, and of half of that in each quadrant."""
WHOLE_RINGS = 2
BORDER = 1
"""A target may have so many more rings than stated: its border."""
HIDDEN = 0.08
"""Of the way round: shorter gaps are spokes."""
JUMP = (0.62, 1.6)
"""From ring to ring their distance grows or shrinks by a factor that itself changes less than this."""
SHRINKING, SPARE, BEYOND_PAPER = 0.4, 0.3, 5.0
"""The distance to the next ring is at least this fraction of the last; fraction of the last distance that the paper may
fall short of the rings that are stated; px of picture beyond the paper that show that it ends.
"""
PLAIN = 8.0
"""px between rings from which none is overlooked for being too close to the next."""
EXPECTED = 0.5
"""Fraction of the rays that must agree."""


def picture_of_target(image: NDArray[Any]) -> Array:
    """The brightness (h, w) of a picture as fractions of full scale; refuses what is no picture or over-exposed."""
    if image.ndim not in (2, 3) or image.dtype not in (np.uint8, np.uint16) or min(image.shape[:2]) < SMALLEST:
        raise ImageError(
            f"A ring target needs a picture of at least {SMALLEST} x {SMALLEST} px with 8 or 16 bit, "
            f"got {' x '.join(map(str, image.shape[:2]))} {image.dtype}."
        )
    image = image[..., :3] if image.ndim == 3 else image
    brightest = int(image.max())
    if brightest in FULL_SCALES:
        bright = image > brightest / 2
        part = float((image == brightest).sum() / bright.sum())
        if part > SATURATED:
            raise ImageError(
                f"The picture is over-exposed: {100 * part:.0f} % of its bright pixels are at full scale "
                f"({brightest}); photograph the target with a shorter exposure."
            )
    elif image.dtype == np.uint8 and (paper := float(np.quantile(image, 0.99))) < DARKEST * 255:
        raise ImageError(
            f"The picture is under-exposed: its brightest parts are at {paper:.0f} of 255; photograph the target with "
            "more light or a longer exposure."
        )
    plane = image if image.ndim == 2 else image.mean(axis=2)
    return plane / float(np.iinfo(image.dtype).max)


def chosen_spokes(tries: Iterable[tuple[Spoke, ...]], size: tuple[int, int], stated: int) -> tuple[Spoke, ...]:
    """The spokes round the likeliest of several centres; refuses a picture (width, height) without target."""
    best: tuple[Spoke, ...] = ()
    for spokes in tries:
        if len(spokes) == stated and _inside(spokes[0].centre, size):
            return spokes
        best = max(best, spokes, key=len)
    if len(best) < 2:
        raise ImageError(
            "No ring target was found: nowhere do dark spokes meet on a lighter ground. Photograph the whole target, "
            "in focus, evenly lit, with its centre in the picture."
        )
    u, v = best[0].centre
    if not _inside(best[0].centre, size):
        raise ImageError(
            f"The target's centre lies outside the picture, at about u = {u:.0f} px, v = {v:.0f} px of "
            f"{size[0]} x {size[1]} px; move it into the middle half of the picture."
        )
    raise ImageError(
        f"{len(best)} spokes were found to meet at u = {u:.0f} px, v = {v:.0f} px where {stated} are stated; correct "
        "spokes in target.toml, or photograph the target in focus, evenly lit and with nothing before it."
    )


def _inside(centre: Array, size: tuple[int, int]) -> bool:
    return bool(0 <= centre[0] <= size[0] - 1 and 0 <= centre[1] <= size[1] - 1)


def counted_rings(dips: Dips, stated: int) -> int:
    """How many rings from the inside can be used; refuses counts that contradict what is stated, and gaps."""
    seen = np.bincount(dips.ring, minlength=stated + 2)[1:] >= SEEN * dips.azimuths.size
    count = int(np.argmin(np.append(seen, False)))
    if count < min(FEWEST_RINGS, stated):
        raise ImageError(
            f"Only {count} rings of the target could be told apart; photograph it in focus, evenly lit and nearer, so "
            f"that at least {FEWEST_RINGS} whole rings are seen."
        )
    _refuse_one_sided(dips, min(WHOLE_RINGS, count))
    _refuse_gaps(dips, count)
    if count > stated + BORDER:
        raise ImageError(
            f"{count} rings were found where {stated} are stated; correct rings in target.toml, which counts all rings "
            "but a border."
        )
    if count < stated:
        _refuse_absence(dips, count, stated)
    return min(count, stated)


def _refuse_one_sided(dips: Dips, rings: int) -> None:
    from scipy.ndimage import grey_closing

    for ring in range(1, rings + 1):
        seen = np.zeros(dips.azimuths.size)
        seen[dips.ray[dips.ring == ring]] = 1
        seen = grey_closing(seen, size=int(HIDDEN * seen.size), mode="wrap")
        quadrants = seen.reshape(4, -1).mean(axis=1)
        if seen.mean() < WHOLE or quadrants.min() < WHOLE / 2:
            towards = ("lower right", "lower left", "upper left", "upper right")[int(quadrants.argmin())]
            raise ImageError(
                f"Ring {ring} is seen on only {100 * seen.mean():.0f} % of its way round, least towards the {towards}; "
                f"photograph the target so that at least {WHOLE_RINGS} whole rings, large enough to be told from the "
                "spokes, and parts of the others on all sides are in the picture."
            )


def _refuse_gaps(dips: Dips, count: int) -> None:
    """Refuses rings whose distances jump: one between them was not seen, or something else was taken for a ring."""
    steps = np.diff(_radii(dips, count), axis=0, prepend=0.0)
    changes = []
    for outer, inner in zip(steps[1:], steps[:-1], strict=True):
        both = np.isfinite(outer / inner)
        changes.append(float(np.median(outer[both] / inner[both])) if both.any() else np.nan)
    for ring, change in enumerate(changes, 1):
        beside = np.array([changes[other - 1] for other in (ring - 1, ring + 1) if 1 <= other <= len(changes)])
        jumps = ~((change > JUMP[0] * beside) & (change < JUMP[1] * beside)) & np.isfinite(change * beside)
        if jumps.size and jumps.all():
            raise ImageError(
                f"The distance between rings changes by a factor of {change:.2f} at ring {ring}: a ring was missed or "
                "something else was taken for one; photograph the target evenly lit, with nothing before it."
            )


def _refuse_absence(dips: Dips, count: int, stated: int) -> None:
    """Refuses a target whose paper ends, well within the picture, before the rings that are stated could come."""
    steps = np.diff(_radii(dips, count), axis=0, prepend=0.0)
    shrinking = np.clip(steps[-1] / steps[-2], SHRINKING, 1.0)
    needed = steps[-1] * (sum(shrinking**more for more in range(1, stated - count + 1)) - SPARE)
    last = steps.sum(axis=0)
    ends = (dips.paper < last + needed) & (dips.paper < dips.frame - BEYOND_PAPER) & (steps[-1] > PLAIN)
    known = np.isfinite(needed)
    if known.any() and ends[known].mean() > EXPECTED:
        raise ImageError(
            f"{count} rings were found where {stated} are stated, and the paper ends there; correct rings in "
            "target.toml."
        )


def _radii(dips: Dips, count: int) -> Array:
    """Radius (rings, rays) [px], NaN where a ring was not seen."""
    radius = np.full((count, dips.azimuths.size), np.nan)
    for ring in range(1, count + 1):
        member = dips.ring == ring
        radius[ring - 1, dips.ray[member]] = dips.radius[member]
    return radius

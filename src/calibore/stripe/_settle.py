"""A second look at the line that was chosen, as `native/src/stripe/settle.rs`.

A peak fitted from its own place and height takes its own speckle for the line: that costs a tenth of what the samples
know. So every ray is fitted once more from where its neighbours say that the line is, as high as it is on average
there, weighted by the inverse of the whole covariance of its samples. The neighbours only choose the standpoint and the
weights. The place is the ray's own, and one that has left it is fitted from where it was.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._across import speckle_across
from calibore.stripe._alone import alone
from calibore.stripe._anchor import anchor
from calibore.stripe._breadth import breadths
from calibore.stripe._estimators import Estimator, ScanSettings
from calibore.stripe._flanks import flanks_of, learn_flanks
from calibore.stripe._generalised import generalised_step
from calibore.stripe._neighbours import Standpoint, standpoints
from calibore.stripe._noise import NoiseModel
from calibore.stripe._picture import Picture, bilinear, inside_of
from calibore.stripe._plateau import bright_rays, plateau_middles
from calibore.stripe._rays import Rays
from calibore.stripe._refine import LONGEST_STEP
from calibore.stripe._scatter import neighbour_scatter
from calibore.stripe._smear import unsmeared
from calibore.stripe._windows import Windows, standing, windows_about

Array = NDArray[np.float64]
FLOORS = (0.0014, 0.01, 0.07, 0.5)
"""Additive noise tried, as fractions of the line's height, for what the model leaves over of the line."""
WORTH = 0.97
"""A higher floor is taken if the scatter is less than this part of the least under a lower one."""
REACH, NEAR = 6.0, 3.0
"""Line widths along the line, on each side, within which neighbours tell where it is: so many at first, fewer when
their places are better, lest they do not see what the wall does."""
FARTHEST = 1.5
"""A step longer than so many line widths, and than `LONGEST_STEP`, has left the line."""
ROUGH = 0.2
"""Where the line is rougher than so many line widths about its neighbours, noise is learnt again from better places."""
LOST = 0.05
"""A floor under which the step leaves more than this share of the peaks is no floor."""
ENOUGH = 375
"""What holds for the whole picture is learnt from so many rays, or a few more."""
MISLED = 4.0
"""Steps longer than this many standard uncertainties: the line is not where the neighbours say."""
SHIFT = 0.2
"""Line widths by which standpoints are moved to see whether that matters ..."""
FEWEST_ASIDE = 24
"""... on so many rays at least."""
GREATEST_PART, MOST_RESPONSE = 4.0, 2.0
"""A ray's response counts as this at most; so does that of all."""


@dataclass(frozen=True)
class Found:
    """The line before: `position`, its uncertainty `u` [px], `height` above `base` of its peaks, NaN where there is
    none; which are `saturated`; each (n,).
    """

    position: Array
    u: Array
    height: Array
    base: Array
    saturated: NDArray[np.bool_]


@dataclass(frozen=True)
class Settled:
    """`position`, `u` (n,) [px] and the noise model that they hold for."""

    position: Array
    u: Array
    noise: NoiseModel


def settle(picture: Picture, rays: Rays, line: Found, settings: ScanSettings) -> Settled:
    """`line` looked at again; only for the default estimator."""
    if settings.estimator is not Estimator.ZERO_CROSSING or not np.isfinite(line.position).any():
        return Settled(line.position, line.u, settings.noise)
    line = _on_plateaus(picture, rays, line, settings)
    look = _look(picture, rays, line, line.position, settings, reach=REACH)
    if look.hidden.any():  # flanks tell much from places that are all a little off
        look = _look(picture, rays, line, _better(look, line), settings, reach=REACH)
    told = look if look.rough <= ROUGH * look.noise.width else None
    look = _look(picture, rays, line, _better(look, line), settings, told, reach=NEAR)
    place, u, noise = look.place, look.u, look.noise
    anchored = anchor(line.position, place, look.calm, u, look.hidden, width=noise.width, spacing=rays.spacing)
    place = place + anchored.aside
    off = np.abs(line.position - place)
    kept, lost = off <= anchored.astray * u, np.isnan(place)
    first, doubt = alone(picture, rays, line.position, lost, replace(settings, noise=noise))
    return Settled(np.where(kept, place, first), np.where(lost, doubt, np.where(kept, u, np.hypot(u, off))), noise)


def _on_plateaus(picture: Picture, rays: Rays, line: Found, settings: ScanSettings) -> Found:
    """`line` with its saturated peaks in the middle of their plateaus."""
    if bright_rays(line.height, line.base, line.saturated, settings, rays) is None:
        return line
    plane = picture.plane()
    samples = bilinear(plane, rays, inside_of(plane, rays))
    return replace(line, position=plateau_middles(samples, line.position, line.height, line.base, line.saturated))


@dataclass(frozen=True)
class Look:
    """What one look has shown: `place` and `u` (n,) [px], NaN where the line was not found again; which rays are `calm`
    (n,) and of which the top is `hidden` (n,); the noise; how `rough` the line was about its neighbours before [px];
    its `height` and `width` (n,), and the `response`.
    """

    place: Array
    u: Array
    calm: NDArray[np.bool_]
    hidden: NDArray[np.bool_]
    noise: NoiseModel
    rough: float
    height: Array
    response: float
    width: Array


def _better(look: Look, line: Found) -> Array:
    """Places (n,) [px] that are better than those of `line` where `look` has found them."""
    return np.where(np.isnan(look.place), line.position, look.place)


def _look(
    picture: Picture,
    rays: Rays,
    line: Found,
    known: Array,
    settings: ScanSettings,
    before: Look | None = None,
    *,
    reach: float,
) -> Look:
    """The line looked at from where the neighbours of each ray say that it is, as far as places are `known` (n,) [px];
    what holds for all of it is as `before`, or learnt.
    """
    width, every = (settings.noise if before is None else before.noise).width, max(known.size // ENOUGH, 1)
    stand = standpoints(known, line.height, within=reach * width, spacing=rays.spacing, closed=rays.closed)
    stand = replace(stand, start=standing(stand.start), height=stand.height if before is None else before.height)
    bright = bright_rays(line.height, line.base, line.saturated, settings, rays)
    widths = np.full(known.size, width) if before is None else before.width
    windows = windows_about(picture, rays, stand.start, widths, settings, bright)
    hidden, longest = np.zeros(known.size, dtype=bool), max(LONGEST_STEP, FARTHEST * width)
    if before is not None:
        noise, response, hidden = before.noise, before.response, before.hidden
        windows = unsmeared(windows, rays, stand.height, noise.width, hidden)
    else:
        noise, seen, flank = replace(settings.noise, additive=settings.sensor), windows, None
        if bright is not None:
            flank = flanks_of(windows, rays, within=reach * width)
            hidden = flank >= 0
            about = {"within": reach * width, "every": every}
            seen, height, noise = learn_flanks(windows, stand, flank, noise, rays, **about)
            widths = seen.width
            stand, windows = replace(stand, height=height), unsmeared(windows, rays, height, noise.width, hidden)
        else:
            width, widths = breadths(windows, stand, width, every=every, closed=rays.closed)
            noise = replace(noise, width=width)
        seen, windows = replace(seen, width=widths), replace(windows, width=widths)
        noise = speckle_across(seen, stand, line.base, noise, every=every, flank=flank)
        noise = _best_floor(windows, stand, rays, noise, every, longest)
        response = _response(windows, stand, noise, every)
    moved, u = generalised_step(windows, stand.height, noise)
    misled = stand.calm & ~(np.abs(moved) <= MISLED * u)
    start = np.where(misled, standing(known), stand.start)
    windows = windows_about(picture, rays, start, widths, settings, bright)
    windows = unsmeared(windows, rays, stand.height, noise.width, hidden)
    moved, u = generalised_step(windows, stand.height, noise)
    place = start + np.where(np.abs(moved / response) <= longest, moved / response, np.nan)
    calm = stand.calm & ~misled
    return Look(place, u / response, calm, hidden, noise, stand.rough, stand.height, response, widths)


def _best_floor(
    windows: Windows, stand: Standpoint, rays: Rays, noise: NoiseModel, every: int, longest: float
) -> NoiseModel:
    """`noise` with the additive noise under which neighbours, of one ray in `every`, agree best.

    What is left of the line when the model is subtracted (compression, halo, a line that is not Gaussian) acts like
    additive noise, in proportion to the line's height, and cannot be seen beside the line: so the scatter decides.
    """
    windows, start = windows.few(every), stand.start[::every]
    known, height = np.isfinite(start), stand.height[::every]
    middle = float(np.median(height[known])) if known.any() else 0.0

    def trial(fraction: float) -> tuple[float, NoiseModel]:
        tried = replace(noise, additive=max(noise.additive, (fraction * middle) ** 2))
        moved, _ = generalised_step(windows, height, tried)
        place = start + np.where(np.abs(moved) <= longest, moved, np.nan)
        if np.count_nonzero(np.isnan(place[known])) > LOST * np.count_nonzero(known):
            return np.inf, tried
        return neighbour_scatter(place, width=noise.width, spacing=rays.spacing * every), tried

    best = trial(FLOORS[0])
    for fraction in FLOORS[1:]:
        tried = trial(fraction)
        best = tried if tried[0] < WORTH * best[0] or np.isinf(best[0]) else best
    return best[1]


def _response(windows: Windows, stand: Standpoint, noise: NoiseModel, every: int) -> float:
    """How far the place found moves per pixel that the line moves, seen from the same standpoint.

    It is one for a line of just the width and height that are assumed; else places would be drawn to the standpoint,
    or away from it. Moving the standpoint tells, for where the line is does not depend on that.
    """
    shift, windows, height = SHIFT * noise.width, windows.few(every), stand.height[::every]
    after, before = (generalised_step(windows, height, noise, aside=side)[0] for side in (shift, -shift))
    per_pixel = ((after - before) / (2 * shift))[stand.calm[::every]]
    per_pixel = per_pixel[np.isfinite(per_pixel)]
    if per_pixel.size < FEWEST_ASIDE:
        return 1.0
    mean = float(np.mean(np.clip(per_pixel, -GREATEST_PART, GREATEST_PART)))
    return float(np.clip(mean, 1 / MOST_RESPONSE, MOST_RESPONSE))

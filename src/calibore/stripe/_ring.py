"""A closed line in an image: find it, centre the rays on it, measure it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.stripe._centre import area_centroid, in_sectors
from calibore.stripe._chain import choose
from calibore.stripe._estimators import ScanSettings, estimator_named
from calibore.stripe._kernel import DEFAULT_KERNEL, link
from calibore.stripe._rays import Rays, annulus, columns
from calibore.stripe._stripe import COARSE, Picture, Stripe, first_look, first_settings, laser_light, learn_noise, measure, prepare

SETTLED = 0.5
"""Re-centring stops when the centre moves less than this many pixels (Swanbom 2007, 6.3.4.3)."""
MOST_RECENTRINGS = 8
LEAST_RING = 0.05
"""A ring must be seen on at least this fraction of the rays."""


def detect_ring(
    image: NDArray[np.generic],
    centre: tuple[float, float],
    *,
    inner: float,
    outer: float,
    channel: str = "luma",
    rays: int = 1500,
    estimator: str = "zero-crossing",
    sectors: Sequence[tuple[float, float]] | None = None,
    kernel: str = DEFAULT_KERNEL,
) -> Stripe:
    """The ring between `inner` and `outer` [px] about roughly `centre` (column, row) in `image` (h, w) or (h, w, 3).

    `sectors`: image azimuths (from, to) [rad] used for centring, e.g. those without features; None uses all.
    Raises ImageError where there is no ring.
    """
    picture = prepare(image, channel)
    named = estimator_named(estimator)
    look = annulus(centre, inner=inner, outer=outer, count=rays)
    settings = first_settings(picture, look, named)
    if settings.prominence >= 0.5 * picture.white or not np.any(picture.plane >= settings.gate):
        raise ImageError("There is no laser ring in the image: nothing stands out from its background.")
    centre, settings = _centred(picture, look, settings, (inner, outer), sectors, kernel)
    final = annulus(centre, inner=inner, outer=outer, count=rays)
    stripe = replace(measure(picture, final, settings, kernel=kernel), centre=centre)
    if stripe.found.mean() < LEAST_RING:
        raise ImageError(f"There is no laser ring in the image: a line was found on {stripe.found.sum()} of {rays} rays.")
    return stripe


def detect_line(
    image: NDArray[np.generic],
    *,
    channel: str = "luma",
    estimator: str = "zero-crossing",
    kernel: str = DEFAULT_KERNEL,
) -> Stripe:
    """A line that crosses `image` from left to right, one peak per column; `u` are the columns, `v` the rows."""
    picture = prepare(image, channel)
    rays = columns(picture.plane.shape)
    settings = first_settings(picture, rays, estimator_named(estimator))
    settings = learn_noise(picture, rays, first_look(picture, rays, settings, kernel=kernel), settings, kernel=kernel)
    return measure(picture, rays, settings, kernel=kernel)


def _centred(
    picture: Picture,
    look: Rays,
    settings: ScanSettings,
    radii: tuple[float, float],
    sectors: Sequence[tuple[float, float]] | None,
    kernel: str,
) -> tuple[tuple[float, float], ScanSettings]:
    """(centre, settings with the noise learnt): unwrap, find the area centroid, start again from there until it rests."""
    start = look.start - radii[0] * look.direction
    centre = (float(start[0, 0]), float(start[0, 1]))
    for step in range(MOST_RECENTRINGS):
        coarse = annulus(centre, inner=radii[0], outer=radii[1], count=len(look.start) // COARSE)
        peaks = first_look(picture, coarse, settings, kernel=kernel)
        settings = learn_noise(picture, coarse, peaks, settings, kernel=kernel) if step == 0 else settings
        laser = laser_light(picture, coarse, peaks, settings.noise.width)
        length = link(np.where(laser, peaks.position, np.nan), spacing=coarse.spacing, closed=True, kernel=kernel)
        pick, status = choose(np.where(laser, length, np.isfinite(peaks.position)), laser)
        azimuth = np.arctan2(coarse.direction[:, 1], coarse.direction[:, 0])
        seen = (status <= 2) & in_sectors(azimuth, sectors)
        if seen.sum() < 8:
            raise ImageError("There is no laser ring in the image: too few connected peaks to find its centre.")
        column, row = coarse.at(peaks.position[np.arange(len(pick)), pick])
        moved = area_centroid(column[seen], row[seen])
        shift = float(np.hypot(moved[0] - centre[0], moved[1] - centre[1]))
        centre = moved
        if shift < SETTLED:
            break
    return centre, settings

"""The whole measurement of a line in NumPy: the readable specification of `native/src/stripe/`, and its fallback.

Both find the same peaks with the same statuses, places within 1e-4 px and uncertainties within 1e-3 of each other.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.status import Status
from calibore.stripe._centre import area_centroid
from calibore.stripe._chain import choose, link
from calibore.stripe._estimators import Estimator, Peaks, ScanSettings
from calibore.stripe._guide import COARSE, guided_spans
from calibore.stripe._learn import first_settings, learn_noise
from calibore.stripe._light import laser_light
from calibore.stripe._picture import Picture
from calibore.stripe._rays import Rays, annulus, columns
from calibore.stripe._scan import scan
from calibore.stripe._scatter import observe_scatter
from calibore.stripe._stripe import Stripe

Array = NDArray[np.float64]
SETTLED = 0.5
"""Re-centring stops when the centre moves less than this many pixels (Swanbom 2007, 6.3.4.3)."""
MOST_RECENTRINGS = 8
FEWEST_TO_CENTRE = 8
"""Coarse rays on which the line must be seen to find its centre."""
UNCLEAR = 0.5
"""Noise that asks peaks to be higher than this fraction of white leaves no room for a ring."""


@dataclass(frozen=True)
class Annulus:
    """Where a ring is looked for: about `centre` (column, row) [px], from `inner` to `outer` [px], on `count` rays.

    `counted` (ceil(count / COARSE),): which coarse rays count for centring.
    """

    centre: tuple[float, float]
    inner: float
    outer: float
    count: int
    counted: NDArray[np.bool_]

    def rays(self) -> Rays:
        return annulus(self.centre, inner=self.inner, outer=self.outer, count=self.count)


def ring_numpy(picture: Picture, ring: Annulus, estimator: Estimator, *, guided: bool = True) -> Stripe:
    """The ring in `picture`; not `guided`, every ray is scanned in full length. Raises ImageError without a ring."""
    settings = first_settings(picture, ring.rays(), estimator)
    if settings.prominence >= UNCLEAR * picture.white:
        raise ImageError("There is no laser ring in the image: nothing stands out from its background.")
    spans = None
    for step in range(MOST_RECENTRINGS):
        coarse = ring.rays().every(COARSE)
        peaks = scan(picture.plane(), coarse, settings.plain(), spans=spans)
        if not np.isfinite(peaks.position).any():
            raise ImageError("There is no laser ring in the image: nothing stands out from its background.")
        settings = learn_noise(picture, coarse, peaks, settings) if step == 0 else settings
        centre = _centre(picture, coarse, peaks, settings, ring.counted)
        shift = float(np.hypot(centre[0] - ring.centre[0], centre[1] - ring.centre[1]))
        ring = replace(ring, centre=centre)
        if guided:
            spans = guided_spans(peaks.position, samples=coarse.samples, spacing=coarse.spacing, shift=shift)
        if shift < SETTLED:
            break
    rays = ring.rays()
    stripe = _measure(picture, rays, settings, None if spans is None else spans[np.arange(rays.count) // COARSE])
    return replace(stripe, centre=ring.centre)


def line_numpy(picture: Picture, estimator: Estimator) -> Stripe:
    """The line that crosses `picture` from left to right."""
    rays = columns(picture.image.shape)
    settings = first_settings(picture, rays, estimator)
    peaks = scan(picture.plane(), rays, settings.plain())
    return _measure(picture, rays, learn_noise(picture, rays, peaks, settings), None)


def _centre(
    picture: Picture, rays: Rays, peaks: Peaks, settings: ScanSettings, counted: NDArray[np.bool_]
) -> tuple[float, float]:
    """Area centroid (column, row) of the line among `peaks` along `rays`, those that are `counted`."""
    pick, status = _line(picture, rays, peaks, settings.noise.width)
    seen = (status <= Status.RESOLVED) & counted
    if seen.sum() < FEWEST_TO_CENTRE:
        raise ImageError("There is no laser ring in the image: too few connected peaks to find its centre.")
    column, row = rays.at(peaks.position[np.arange(len(pick)), pick])
    try:
        return area_centroid(column[seen], row[seen])
    except InputError:
        raise ImageError("There is no laser ring in the image: its peaks enclose no area.") from None


def _line(picture: Picture, rays: Rays, peaks: Peaks, width: float) -> tuple[NDArray[np.intp], NDArray[np.uint8]]:
    """Which candidate on each ray is the line, and the status of the choice."""
    laser = laser_light(picture, rays, peaks, width)
    length = rays.stride * link(np.where(laser, peaks.position, np.nan), spacing=rays.spacing, closed=rays.closed)
    return choose(np.where(laser, length, np.isfinite(peaks.position)), laser, peaks.height)


def _measure(picture: Picture, rays: Rays, settings: ScanSettings, spans: NDArray[np.int64] | None) -> Stripe:
    """The line along `rays`: candidates, choice by continuity, uncertainty from model and scatter."""
    peaks = scan(picture.plane(), rays, settings, spans=spans)
    pick, status = _line(picture, rays, peaks, settings.noise.width)
    rows = np.arange(rays.count)
    status[(status <= Status.RESOLVED) & peaks.saturated[rows, pick]] = Status.SATURATED
    valued = status <= Status.SATURATED
    position, u, height = (
        np.where(valued, table[rows, pick], np.nan) for table in (peaks.position, peaks.u, peaks.height)
    )
    scatter = observe_scatter(position, u, width=settings.noise.width, spacing=rays.spacing, closed=rays.closed)
    column, row = rays.at(position)
    return Stripe(
        column,
        row,
        rays.direction,
        u * scatter.scale,
        status,
        height,
        scatter.correlation,
        settings.noise,
        scatter.scale,
    )

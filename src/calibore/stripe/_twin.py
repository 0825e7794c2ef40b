"""The whole measurement of a line in NumPy: the readable specification of `native/src/stripe/`, and its fallback.

Both find the same peaks with the same statuses, places within 1e-4 px and uncertainties within 1e-3 of each other.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.status import Status
from calibore.stripe._centre import ring_centre
from calibore.stripe._chain import slack_of
from calibore.stripe._choice import choose
from calibore.stripe._estimators import Estimator, Peaks, ScanSettings
from calibore.stripe._guide import COARSE, LEAST_MARGIN, guided_spans
from calibore.stripe._learn import first_settings, learn_noise
from calibore.stripe._light import laser_light
from calibore.stripe._picture import Picture
from calibore.stripe._rays import Rays, annulus, columns, rows
from calibore.stripe._ridge import ridges
from calibore.stripe._scan import scan
from calibore.stripe._scatter import observe_scatter
from calibore.stripe._settle import Found, settle
from calibore.stripe._stripe import Stripe

Array = NDArray[np.float64]
SETTLED = 0.5
"""Re-centring stops when the centre moves less than this many pixels (Swanbom 2007, 6.3.4.3)."""
MOST_RECENTRINGS = 8
FEWEST_TO_CENTRE = 8
"""Coarse rays on which the line must be seen to find its centre."""
LEARNT = 192
"""Rays across a line, about as many as round a ring, that tell its noise and where to look on those between."""
MOST_RAYS, MOST_SAMPLES = 1 << 14, 1 << 22
"""Of a ring: half a gigabyte, as all are kept at once."""
UNCLEAR = 0.5
"""Noise that asks peaks to be higher than this fraction of white leaves no room for a ring."""


@dataclass(frozen=True)
class Annulus:
    """Where a ring is looked for: about `centre` (column, row) [px], from `inner` to `outer` [px], on `count` rays.

    `counted` (count,): which rays count for centring.
    """

    centre: tuple[float, float]
    inner: float
    outer: float
    count: int
    counted: NDArray[np.bool_]

    def rays(self) -> Rays:
        return annulus(self.centre, inner=self.inner, outer=self.outer, count=self.count)


def ring_numpy(picture: Picture, ring: Annulus, estimator: Estimator, *, guided: bool = True) -> Stripe:
    """The ring in `picture`; not `guided`, every ray is scanned in full length. Raises ImageError without a ring.

    Unwrap the annulus, find the line and its centre, start again from there until it rests. Raises InputError where
    that would take too much memory.
    """
    _check_size(ring.rays())
    ring, settings, coarse = _approach(picture, ring, estimator)
    recentrings = 0
    while True:
        rays = ring.rays()
        spans = coarse.spans(ring.centre)[np.arange(rays.count) // COARSE] if guided else None
        sight = _sight(
            picture, rays, scan(picture.plane(), rays, settings.choosing(), spans=spans), settings.noise.width
        )
        centre = _centre(sight, ring.counted)
        recentrings += 1
        if _distance(centre, ring.centre) < SETTLED or recentrings == MOST_RECENTRINGS:
            return replace(_measure(picture, sight, settings), centre=ring.centre)
        ring = replace(ring, centre=centre)


def _check_size(rays: Rays) -> None:
    if rays.count > MOST_RAYS or rays.count * rays.samples > MOST_SAMPLES:
        raise InputError(
            f"The NumPy kernel has memory for {MOST_RAYS} rays and {MOST_SAMPLES} samples, got {rays.count} rays "
            f"of {rays.samples}; ask for fewer, for a narrower search region, or for the native kernel."
        )


def line_numpy(picture: Picture, estimator: Estimator, *, down: bool, guided: bool = True) -> Stripe:
    """The line that crosses `picture` from left to right, or runs `down` it; `guided` as for a ring."""
    rays = (rows if down else columns)(picture.image.shape)
    settings = first_settings(picture, rays, estimator)
    stride = min(max(1, rays.count // LEARNT), COARSE)
    few = rays.every(stride)
    peaks = scan(picture.plane(), few, settings.plain())
    settings = learn_noise(picture, few, peaks, settings)
    spans = guided_spans(peaks.position, samples=few.samples, spacing=few.spacing, shift=0.0)
    spans = spans[np.arange(rays.count) // stride] if guided else None
    peaks = scan(picture.plane(), rays, settings.choosing(), spans=spans)
    return _measure(picture, _sight(picture, rays, peaks, settings.noise.width), settings)


@dataclass(frozen=True)
class Approach:
    """What the last coarse scan along `rays` from `centre` has found."""

    rays: Rays
    peaks: Peaks
    centre: tuple[float, float]

    def spans(self, centre: tuple[float, float]) -> NDArray[np.int64]:
        """Where to look for peaks on the rays from `centre`; see `guided_spans`."""
        shift = _distance(centre, self.centre)
        return guided_spans(self.peaks.position, samples=self.rays.samples, spacing=self.rays.spacing, shift=shift)


def _approach(picture: Picture, ring: Annulus, estimator: Estimator) -> tuple[Annulus, ScanSettings, Approach]:
    """Coarse scans: learn the settings, and move `ring` until it is near enough for the last scan to guide."""
    settings = first_settings(picture, ring.rays(), estimator)
    if settings.prominence >= UNCLEAR * picture.white:
        raise ImageError("There is no laser ring in the image: nothing stands out from its background.")
    recentrings = 0
    while True:
        rays = ring.rays().every(COARSE)
        peaks = scan(picture.plane(), rays, settings.plain())
        if not np.isfinite(peaks.position).any():
            raise ImageError("There is no laser ring in the image: nothing stands out from its background.")
        settings = learn_noise(picture, rays, peaks, settings) if recentrings == 0 else settings
        approach = Approach(rays, peaks, ring.centre)
        ring = replace(ring, centre=_centre(_sight(picture, rays, peaks, settings.noise.width), ring.counted))
        recentrings += 1
        if _distance(ring.centre, approach.centre) <= LEAST_MARGIN or recentrings == MOST_RECENTRINGS:
            return ring, settings, approach


@dataclass(frozen=True)
class Sight:
    """The candidates along rays, which of them (`pick`, n) is the line on each, and `status` and `confidence` (n,) of
    the choice.
    """

    rays: Rays
    peaks: Peaks
    pick: NDArray[np.intp]
    status: NDArray[np.uint8]
    confidence: Array

    def picked(self, table: NDArray[Any]) -> NDArray[Any]:
        """`table` (n, k) of the line's candidates, (n,)."""
        return table[np.arange(self.rays.count), self.pick]


def _sight(picture: Picture, rays: Rays, peaks: Peaks, width: float) -> Sight:
    """The line of `width` [px] among `peaks` along `rays`."""
    laser = laser_light(picture, rays, peaks, width)
    along: dict[str, Any] = {"spacing": rays.spacing, "closed": rays.closed, "stride": rays.stride}
    return Sight(rays, peaks, *choose(peaks.position, peaks.height, laser, slack=slack_of(width), **along))


def _centre(sight: Sight, counted: NDArray[np.bool_]) -> tuple[float, float]:
    """Centre (column, row) of the line in `sight`, by the rays that are `counted`."""
    seen = (sight.status <= Status.RESOLVED) & counted[:: sight.rays.stride]
    if seen.sum() < FEWEST_TO_CENTRE:
        raise ImageError("There is no laser ring in the image: too few connected peaks to find its centre.")
    column, row = sight.rays.at(sight.picked(sight.peaks.position))
    try:
        return ring_centre(column, row, seen)
    except InputError:
        raise ImageError("There is no laser ring in the image: its peaks lie on no circle.") from None


def _distance(one: tuple[float, float], other: tuple[float, float]) -> float:
    return float(np.hypot(one[0] - other[0], one[1] - other[1]))


def _measure(picture: Picture, sight: Sight, settings: ScanSettings) -> Stripe:
    """The line in sight, looked at again, with its uncertainty from model and scatter."""
    rays, peaks, status = sight.rays, sight.peaks, sight.status.copy()
    status[(status <= Status.RESOLVED) & sight.picked(peaks.saturated)] = Status.SATURATED
    valued = status <= Status.SATURATED
    tables = (peaks.position, peaks.u, peaks.height, peaks.background)
    position, u, height, base = (np.where(valued, sight.picked(table), np.nan) for table in tables)
    if settings.estimator is Estimator.STEGER:
        position, u = ridges(picture.plane(), rays, position, height, settings)
        lost = np.isnan(position)
        height[lost], status[lost & valued] = np.nan, Status.NO_PEAK
    settled = settle(picture, rays, Found(position, u, height, base, status == Status.SATURATED), settings)
    width = settled.noise.width
    scatter = observe_scatter(settled.position, settled.u, width=width, spacing=rays.spacing, closed=rays.closed)
    (column, row), u, shared = rays.at(settled.position), settled.u * scatter.scale, scatter.correlation
    seen = column, row, rays.direction, u, status, height, shared
    return Stripe(*seen, settled.noise, scatter.scale, confidence=sight.confidence)

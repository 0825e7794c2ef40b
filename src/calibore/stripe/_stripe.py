"""The lit line in one image: peaks, statuses and their uncertainty along a set of rays."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.status import Status
from calibore.stripe._chain import choose
from calibore.stripe._estimators import (
    PUBLISHED_THRESHOLD,
    Estimator,
    Peaks,
    ScanSettings,
)
from calibore.stripe._kernel import link, ratios_of, scan
from calibore.stripe._noise import NoiseModel, background_noise, pixel_noise, speckle
from calibore.stripe._rays import Rays
from calibore.stripe._scatter import neighbour_scatter, observe_scatter

Array = NDArray[np.float64]
COARSE = 4
"""Every fourth ray is enough to find the centre and to learn the noise."""
PROMINENT = 6.0
"""A peak stands out by this many standard deviations of the background noise ..."""
FAINTEST = 0.08
"""... and by this fraction of the line's typical height."""
WIDEST = 3.0
"""Light wider than this many line widths is not the laser line."""
FEWEST_TO_LEARN = 24
"""Peaks needed to learn a noise model."""
FLOORS = (0.01, 0.07, 0.5)
"""Additive noise tried, as fractions of the line's height; the optimum is flat, factors of seven are fine enough."""
FOREIGN = 0.35
"""A peak whose other colours exceed its own by this much more than the line's typically do is not laser light."""


@dataclass(frozen=True)
class Stripe:
    """One line in one image, n rays. NaN where `status` has no value.

    `u`, `v` (n,) pixel coordinates (column, row) of the peaks; `direction` (n, 2) of the ray each was measured along;
    `u_position` (n,) [px] standard uncertainty along that ray; `correlation` (k,) of neighbouring peaks at lags 1 .. k;
    `height` (n,) [grey values]; `noise` the noise model used; `scale` the observed over the modelled scatter, already
    contained in `u_position`; `centre` (column, row) the rays start from, or None where they are not a ring's.
    """

    u: Array
    v: Array
    direction: Array
    u_position: Array
    status: NDArray[np.uint8]
    height: Array
    correlation: Array
    noise: NoiseModel
    scale: float
    centre: tuple[float, float] | None = None

    @property
    def found(self) -> NDArray[np.bool_]:
        return self.status <= Status.SATURATED


@dataclass(frozen=True)
class Picture:
    """An image prepared for scanning: `image` (h, w) or (h, w, 3), the colour `band` looked at, its white level."""

    image: NDArray[np.generic]
    band: int
    white: float

    @property
    def plane(self) -> NDArray[np.generic]:
        return self.image if self.image.ndim == 2 else self.image[:, :, self.band]

    @property
    def is_colour(self) -> bool:
        return self.image.ndim == 3


def prepare(image: NDArray[np.generic], channel: str) -> Picture:
    """`image` (h, w) or (h, w, 3), uint8 or uint16, seen in `channel` ("red", "green", "blue" or "luma")."""
    if image.dtype not in (np.uint8, np.uint16) or image.ndim not in (2, 3):
        raise ImageError(f"An image must be uint8 or uint16 with 1 or 3 bands, got {image.dtype} {image.shape}.")
    white = float(np.iinfo(image.dtype).max)
    if image.ndim == 2:
        return Picture(image, 0, white)
    if channel == "luma":
        luma = (image @ np.array([0.299, 0.587, 0.114])).round().astype(image.dtype)  # Rec. 601, as JPEG and video use
        return Picture(luma, 0, white)
    return Picture(image, {"red": 0, "green": 1, "blue": 2}[channel], white)


def first_settings(picture: Picture, rays: Rays, estimator: Estimator) -> ScanSettings:
    """Settings for the first look, from a sparse sample of the search region."""
    sparse = rays.every(max(1, len(rays.start) // 96))
    column, row = sparse.at(np.broadcast_to(np.arange(float(rays.samples)), (len(sparse.start), rays.samples)))
    height, width = picture.plane.shape
    inside = (column >= 0) & (row >= 0) & (column <= width - 1) & (row <= height - 1)
    if not inside.any():
        raise ImageError("The region where the ring is expected lies outside the image.")
    c, r = np.where(inside, column + 0.5, 0).astype(np.intp), np.where(inside, row + 0.5, 0).astype(np.intp)
    values = picture.plane[r, c].astype(np.float32)
    known = values[inside]
    floor = float(np.partition(known, known.size // 20)[known.size // 20])
    brightest = np.where(inside, values, -1.0).max(axis=1)
    level = max(float(np.median(brightest[brightest >= 0])) - floor, 0.0)
    noise = background_noise(values[:, 2:] - values[:, :-2], inside[:, 2:] & inside[:, :-2])
    prominence = max(PROMINENT * noise, FAINTEST * level)
    model = NoiseModel(additive=noise**2, contrast=0.04)
    threshold = PUBLISHED_THRESHOLD * picture.white / 255 if estimator is Estimator.PARABOLA else 0.0
    return ScanSettings(estimator, model, floor + 0.6 * prominence, prominence, threshold, picture.white)


def first_look(picture: Picture, rays: Rays, settings: ScanSettings, *, kernel: str) -> Peaks:
    """Candidates by slope alone: enough to find the line and learn its noise."""
    plain = settings if settings.estimator is Estimator.PARABOLA else replace(settings, estimator=Estimator.CROSSING)
    return scan(picture.image, rays, plain, band=picture.band, kernel=kernel)


def learn_noise(picture: Picture, rays: Rays, peaks: Peaks, settings: ScanSettings, *, kernel: str) -> ScanSettings:
    """`settings` with the noise model, line width and window learnt from the `peaks` found along `rays`."""
    good = np.isfinite(peaks.position[:, 0]) & ~peaks.saturated[:, 0]
    if good.sum() < FEWEST_TO_LEARN:
        return settings
    width = float(np.clip(np.median(peaks.width[good, 0]), 0.6, 12.0))
    column, row = rays.at(peaks.position[:, 0])
    additive, gain = pixel_noise(picture.plane, column[good], row[good], rays.direction[good])
    model = replace(settings.noise, additive=max(additive, settings.noise.additive), gain=gain, width=width)
    height = np.where(good, peaks.height[:, 0], np.nan)
    model = speckle(model, height, spacing=rays.spacing)
    window = settings.window if settings.estimator is Estimator.PARABOLA else int(np.clip(2 * round(2 * width), 6, 32))
    settings = replace(settings, noise=model, window=window)
    return best_floor(picture, rays.near(peaks.position[:, 0], 2 * settings.reach), settings, peaks, kernel=kernel)


def best_floor(picture: Picture, rays: Rays, settings: ScanSettings, peaks: Peaks, *, kernel: str) -> ScanSettings:
    """`settings` with the additive noise under which neighbouring peaks agree best; `rays` short ones about `peaks`.

    What is left of the line when the model is subtracted (compression, halo, a line that is not Gaussian) acts like
    additive noise, in proportion to the line's height, and cannot be seen beside the line: so the scatter decides.
    """
    if settings.estimator is not Estimator.ZERO_CROSSING:
        return settings
    first = np.floor(peaks.position[:, 0]) - 2 * settings.reach
    height, trials = float(np.nanmedian(peaks.height[:, 0])), []
    for fraction in FLOORS:
        noise = replace(settings.noise, additive=max(settings.noise.additive, (fraction * height) ** 2))
        trial = replace(settings, noise=noise)
        place = first + scan(picture.image, rays, trial, band=picture.band, kernel=kernel).position[:, 0]
        scatter = neighbour_scatter(place, width=noise.width, spacing=rays.spacing, ratios=ratios_of(kernel))
        trials.append((scatter, fraction, trial))
    return min(trials, key=lambda trial: trial[:2])[2]


def laser_light(picture: Picture, rays: Rays, peaks: Peaks, width: float) -> NDArray[np.bool_]:
    """Which candidates (n, k) look like laser light: about as wide as the line, and of its colour."""
    present = np.isfinite(peaks.position)
    laser = present & (peaks.width <= WIDEST * width)
    if not picture.is_colour:
        return laser
    excess = foreign_share(picture, rays, peaks)
    typical = np.nanmedian(np.where(laser, excess, np.nan)) if laser.any() else 0.0
    return laser & ~(excess > typical + FOREIGN)


def foreign_share(picture: Picture, rays: Rays, peaks: Peaks) -> Array:
    """Brightest other colour over the own colour, above the background two line widths and more away; (n, k)."""
    column, row = rays.at(np.where(np.isfinite(peaks.position), peaks.position, 0.0))
    height, width = picture.plane.shape
    c, r = (np.clip(np.rint(a), 0, n - 1).astype(np.intp) for a, n in ((column, width), (row, height)))
    pixel = picture.image[r, c].astype(np.float64)
    others = [band for band in range(3) if band != picture.band]
    own = np.maximum(pixel[:, :, picture.band] - peaks.background, 1.0)
    rest = pixel[:, :, others].max(axis=2) - peaks.background
    return np.where(np.isfinite(peaks.position), rest / own, np.nan)


def measure(picture: Picture, rays: Rays, settings: ScanSettings, *, kernel: str) -> Stripe:
    """The line along `rays`: candidates, choice by continuity, uncertainty from model and scatter."""
    peaks = scan(picture.image, rays, settings, band=picture.band, kernel=kernel)
    laser = laser_light(picture, rays, peaks, settings.noise.width)
    place = np.where(laser, peaks.position, np.nan)
    length = link(place, spacing=rays.spacing, closed=rays.closed, kernel=kernel)
    pick, status = choose(np.where(laser, length, np.isfinite(peaks.position)), laser)
    rows = np.arange(len(pick))
    status[(status <= Status.RESOLVED) & peaks.saturated[rows, pick]] = Status.SATURATED
    valued = status <= Status.SATURATED
    position, u = (np.where(valued, table[rows, pick], np.nan) for table in (peaks.position, peaks.u))
    scatter = observe_scatter(position, u, width=settings.noise.width, spacing=rays.spacing, closed=rays.closed, ratios=ratios_of(kernel))
    column, row = rays.at(position)
    height = np.where(valued, peaks.height[rows, pick], np.nan)
    return Stripe(
        column, row, rays.direction, u * scatter.scale, status, height, scatter.correlation, settings.noise, scatter.scale
    )

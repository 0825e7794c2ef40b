"""Settings of a scan, learnt from the picture: first a rough look, then the noise and width of the line."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.stripe._estimators import PUBLISHED_THRESHOLD, Estimator, Peaks, ScanSettings
from calibore.stripe._noise import QUANTISATION, NoiseModel, background_noise, pixel_noise, speckle
from calibore.stripe._picture import Picture, inside_of, nearest_pixels
from calibore.stripe._rays import Rays

Array = NDArray[np.float64]
SPARSE = 48
"""Rays enough for the first estimate of floor, level and noise."""
COUNTED = 256
"""Samples of a sparse ray, at least, that tell floor and noise; its brightest one is looked for among all."""
FLOOR_RANK = 20
"""The floor is the brightness that one sample in this many stays below."""
PROMINENT = 6.0
"""A peak stands out by this many standard deviations of the background noise ..."""
FAINTEST = 0.08
"""... and by this fraction of the line's typical height."""
GATE = 0.6
"""Only samples brighter than the floor by this much of the prominence can be a peak's."""
FEWEST_TO_LEARN = 24
"""Peaks needed to learn a noise model."""
NARROWEST_LINE, WIDEST_LINE = 0.6, 12.0
"""Limits of the line width (Gaussian sigma) [px]."""
SMALLEST_WINDOW, LARGEST_WINDOW = 6, 32
"""Limits of the window to which a slope is fitted [samples]; within them it is four line widths."""


def first_settings(picture: Picture, rays: Rays, estimator: Estimator) -> ScanSettings:
    """Settings for the first look, from a sparse sample of the search region; ImageError if all of it is outside."""
    plane, sparse = picture.plane(), rays.every(max(1, rays.count // SPARSE))
    inside = inside_of(plane, sparse)
    if not inside.any():
        raise ImageError("The region where the ring is expected lies outside the image.")
    values = nearest_pixels(plane, sparse, inside)
    pace = max(1, rays.samples // COUNTED)
    known = values[:, ::pace][inside[:, ::pace]]
    floor = float(np.sort(known)[known.size // FLOOR_RANK]) if known.size else 0.0
    brightest = np.max(np.where(inside, values, -1.0), axis=1)
    level = max(float(np.median(brightest[brightest >= 0])) - floor, 0.0)
    difference, both = values[:, 2:] - values[:, :-2], inside[:, 2:] & inside[:, :-2]
    noise = background_noise(difference[:, ::pace], both[:, ::pace])
    prominence = max(PROMINENT * noise, FAINTEST * level)
    threshold = PUBLISHED_THRESHOLD * picture.white / 255 if estimator is Estimator.PARABOLA else 0.0
    model, gate = NoiseModel(additive=noise**2), floor + GATE * prominence
    return ScanSettings(estimator, model, gate, prominence, threshold, picture.white, sensor=model.additive)


def learn_noise(picture: Picture, rays: Rays, peaks: Peaks, settings: ScanSettings) -> ScanSettings:
    """`settings` with the noise model, line width and window learnt from the `peaks` found along `rays`."""
    good = np.isfinite(peaks.position[:, 0]) & ~peaks.saturated[:, 0]
    if good.sum() < FEWEST_TO_LEARN:
        seen = np.isfinite(peaks.position[:, 0])
        return _broad(settings, peaks.width[seen, 0]) if seen.sum() >= FEWEST_TO_LEARN else settings
    width = float(np.clip(np.median(peaks.width[good, 0]), NARROWEST_LINE, WIDEST_LINE))
    column, row = rays.at(peaks.position[:, 0])
    additive, gain = pixel_noise(picture.plane(), column[good], row[good], rays.direction[good])
    first = settings.noise.additive
    sensor = min(max(additive, QUANTISATION), first) if additive + gain > 0 else first
    model = replace(settings.noise, additive=max(additive, first), gain=gain, width=width)
    model = speckle(model, np.where(good, peaks.height[:, 0], np.nan), spacing=rays.spacing)
    return _broad(replace(settings, noise=model, sensor=sensor), peaks.width[good, 0])


def _broad(settings: ScanSettings, widths: Array) -> ScanSettings:
    """`settings` for a line of the median of the `widths` (n,) [px] of peaks."""
    width = float(np.clip(np.median(widths), NARROWEST_LINE, WIDEST_LINE))
    settings = replace(settings, noise=replace(settings.noise, width=width))
    if settings.estimator is Estimator.PARABOLA:
        return settings
    window = int(np.clip(2 * round(2 * width), SMALLEST_WINDOW, LARGEST_WINDOW))
    return replace(settings, window=window)

"""Settings of a scan, learnt from the picture: first a rough look, then the noise and width of the line."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.stripe._estimators import PUBLISHED_THRESHOLD, Estimator, Peaks, ScanSettings
from calibore.stripe._noise import NoiseModel, background_noise, pixel_noise, speckle
from calibore.stripe._picture import Picture, inside_of, nearest_pixels
from calibore.stripe._rays import Rays
from calibore.stripe._scan import scan
from calibore.stripe._scatter import neighbour_scatter

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
FLOORS = (0.01, 0.07, 0.5)
"""Additive noise tried, as fractions of the line's height; the optimum is flat, factors of seven are fine enough."""
LOST = 0.05
"""A floor under which the step to the model's place leaves more than this share of the peaks is no floor: the scatter
cannot tell, for such peaks keep their first place ..."""
RAISED = 0.03
"""... and instead of the least one this is tried."""


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
    model = NoiseModel(additive=noise**2)
    return ScanSettings(estimator, model, floor + GATE * prominence, prominence, threshold, picture.white)


def learn_noise(picture: Picture, rays: Rays, peaks: Peaks, settings: ScanSettings) -> ScanSettings:
    """`settings` with the noise model, line width and window learnt from the `peaks` found along `rays`."""
    good = np.isfinite(peaks.position[:, 0]) & ~peaks.saturated[:, 0]
    if good.sum() < FEWEST_TO_LEARN:
        return settings
    width = float(np.clip(np.median(peaks.width[good, 0]), NARROWEST_LINE, WIDEST_LINE))
    column, row = rays.at(peaks.position[:, 0])
    additive, gain = pixel_noise(picture.plane(), column[good], row[good], rays.direction[good])
    model = replace(settings.noise, additive=max(additive, settings.noise.additive), gain=gain, width=width)
    model = speckle(model, np.where(good, peaks.height[:, 0], np.nan), spacing=rays.spacing)
    if settings.estimator is Estimator.PARABOLA:
        return replace(settings, noise=model)
    window = int(np.clip(2 * round(2 * width), SMALLEST_WINDOW, LARGEST_WINDOW))
    return best_floor(picture, rays, peaks, replace(settings, noise=model, window=window))


def best_floor(picture: Picture, rays: Rays, peaks: Peaks, settings: ScanSettings) -> ScanSettings:
    """`settings` with the additive noise under which neighbouring `peaks` agree best.

    What is left of the line when the model is subtracted (compression, halo, a line that is not Gaussian) acts like
    additive noise, in proportion to the line's height, and cannot be seen beside the line: so the scatter decides.
    """
    if settings.estimator is not Estimator.ZERO_CROSSING:
        return settings
    spans, height = near(peaks.position[:, 0], 2 * settings.reach), np.nanmedian(peaks.height[:, 0])
    first = scan(picture.plane(), rays, settings.plain(), spans=spans).position[:, 0]

    def trial(fraction: float) -> tuple[float, float, float, ScanSettings]:
        """Scatter, floor, share of lost peaks, settings."""
        noise = replace(settings.noise, additive=max(settings.noise.additive, float(fraction * height) ** 2))
        tried = replace(settings, noise=noise)
        place = scan(picture.plane(), rays, tried, spans=spans).position[:, 0]
        lost = float(np.count_nonzero(place == first) / max(np.count_nonzero(np.isfinite(place)), 1))
        return neighbour_scatter(place, width=noise.width, spacing=rays.spacing), fraction, lost, tried

    least, *higher = map(trial, FLOORS)
    least = trial(RAISED) if least[2] > LOST else least
    trials = higher if least[2] > LOST else [least, *higher]
    return min(trials, key=lambda tried: tried[:2])[3]


def near(position: Array, margin: int) -> NDArray[np.int64]:
    """Spans (n, 2) of samples within `margin` of `position` (n,) [px]; empty where that is NaN."""
    middle = np.floor(np.where(np.isfinite(position), position, 0.0)).astype(np.int64)
    span = np.stack([middle - margin, middle + margin + 2], axis=1)
    return np.where(np.isfinite(position)[:, None], span, 0)

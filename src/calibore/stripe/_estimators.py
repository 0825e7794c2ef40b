"""The estimators of a peak's sub-pixel place, by name, and the settings of one scan along rays."""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from calibore.errors import UsageError
from calibore.stripe._noise import NoiseModel

Array = NDArray[np.float64]


class Estimator(IntEnum):
    """How the place of a peak on its ray is computed (Swanbom 2007, 2.3.3 and 6.3.4.2)."""

    ZERO_CROSSING = 0  # found where the fitted slope changes sign, placed by generalised least squares: the default
    PARABOLA = 1  # vertex of a parabola fitted to 8 samples, threshold 45: reproduces the dissertation
    MAXIMUM = 2  # brightest sample
    THRESHOLD = 3  # midpoint of the two half-height crossings
    CENTROID = 4  # centre of gravity
    CORRELATION = 5  # best match with a Gaussian of the line's width
    CROSSING = 6  # sign change of the fitted slope alone, without uncertainty: for a first look
    STEGER = 7  # where the slope across the line of the smoothed picture is zero (Steger 1998)

    @property
    def label(self) -> str:
        return self.name.lower().replace("_", "-")


MEASURING = tuple((estimator.label, estimator) for estimator in Estimator if estimator is not Estimator.CROSSING)
"""Names are made once: a call takes as long as ten rays."""


def estimator_named(name: str) -> Estimator:
    """The estimator called `name`, e.g. "zero-crossing"; raises UsageError naming all of them."""
    for label, estimator in MEASURING:
        if label == name:
            return estimator
    known = ", ".join(label for label, _ in MEASURING)
    raise UsageError(f'Estimator "{name}" is not known; choose one of {known}.')


PUBLISHED_WINDOW = 8
"""Samples per fitted parabola (Swanbom 2007, 6.3.4.2)."""
PUBLISHED_THRESHOLD = 45.0
"""Least height of a fitted parabola in grey values of 0..255 (Swanbom 2007, 6.3.4.2)."""
SATURATED_FROM = 0.97
"""Samples above this fraction of white carry no information about the line's place."""
NARROWEST_FIT, WIDEST_FIT = 4, 24
"""Limits of the half width of the Gauss-Newton window [samples]."""
MOST_SAMPLES = 25
"""Samples of a ray in a generalised fit."""
MOST_PEAKS = 4
"""Candidates kept per ray, the highest ones."""


@dataclass(frozen=True)
class ScanSettings:
    """One scan along rays. Brightness in grey values, lengths in samples (= pixels).

    `gate`: nearest-pixel brightness below which no peak is looked for; `prominence`: least height above the local
    background; `threshold`: least absolute brightness (0 = none); `white`: the level at which the image saturates;
    `window`: samples to which a slope is fitted; `sensor`: additive variance of the pixels themselves, which that of
    `noise` may exceed.
    """

    estimator: Estimator
    noise: NoiseModel
    gate: float
    prominence: float
    threshold: float
    white: float
    window: int = PUBLISHED_WINDOW
    sensor: float = 1.0

    def plain(self) -> "ScanSettings":
        """The same for a first look: by slope alone, or the dissertation's way throughout."""
        return self if self.estimator is Estimator.PARABOLA else replace(self, estimator=Estimator.CROSSING)

    def choosing(self) -> "ScanSettings":
        """The same for the look in which the line is chosen: what is looked at again needs no more than a place."""
        return self.plain() if self.estimator is Estimator.ZERO_CROSSING else self

    @property
    def reach(self) -> int:
        """Samples on each side of a peak in which its background and half height are looked for."""
        return self.window + 2

    @property
    def half_fit(self) -> int:
        """Half width [samples] of the Gauss-Newton window: three line widths."""
        return int(np.clip(np.ceil(3 * self.noise.width), NARROWEST_FIT, WIDEST_FIT))

    @property
    def group(self) -> int:
        """Neighbouring samples that are averaged for a generalised fit, so that it has no more than it can bear."""
        return -(-(2 * self.half_fit + 1) // MOST_SAMPLES)

    @property
    def saturated_from(self) -> float:
        """Brightness from which a sample counts as saturated."""
        return SATURATED_FROM * self.white


@dataclass(frozen=True)
class Peaks:
    """Candidates on n rays, up to `MOST_PEAKS` each, highest first; NaN (or False) where there is none.

    `position` [px along the ray], `height` above `background` [grey values], `width` (Gaussian sigma from the full
    width at half height) [px], `u` standard uncertainty [px], `saturated`; each (n, MOST_PEAKS).
    """

    position: Array
    height: Array
    background: Array
    width: Array
    u: Array
    saturated: NDArray[np.bool_]

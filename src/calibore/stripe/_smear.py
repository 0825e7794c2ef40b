"""What interpolating between pixels does to a bright line, as `native/src/stripe/smear.rs`.

A sample between pixels is a mean of four, so it sees the line wider than it is: by 1 / 6 px^2 of its variance on
average, but more or less according to where between them the sample lies. Round the whole top of a line that averages
out. On the flanks that are left of a clipped line it is several times the noise of the sensor.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._rays import ONE, Rays
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]
USUAL = 1 / 6
"""px^2: mean over all places between pixels."""


def unsmeared(windows: Windows, rays: Rays, height: Array, width: float, hidden: NDArray[np.bool_]) -> Windows:
    """`windows` as if those rays of a ring on which the top of the line is `hidden` (n,), and itself `height` (n,) and
    `width` [px], were sampled everywhere with the usual smear; rows and columns are not interpolated.
    """
    if not (rays.closed and hidden.any()):
        return windows
    group = int(windows.apart)
    number = np.arange(windows.distance.shape[1] * group)
    distance = windows.distance[:, :1] - (group - 1) / 2 + number
    between = [(place % ONE) / ONE for place in _fixed(rays, windows.first[:, None] + number)]
    narrow = np.sqrt(max(width**2 - USUAL, width**2 / 2))
    seen = np.zeros_like(distance)
    for corner in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = np.prod([part if far else 1 - part for part, far in zip(between, corner, strict=True)], axis=0)
        aside = sum(
            (far - part) * rays.direction[:, axis, None]
            for axis, (part, far) in enumerate(zip(between, corner, strict=True))
        )
        seen += weight * np.exp(-((distance + aside) ** 2) / (2 * narrow**2)) * (width / narrow)
    more = (seen - np.exp(-(distance**2) / (2 * width**2))).reshape(len(height), -1, group).mean(axis=2)
    more = np.where((hidden & (height > 0))[:, None], height[:, None] * more, 0.0)
    return replace(windows, shown=windows.shown - more, value=windows.value - more)


def _fixed(rays: Rays, sample: NDArray[np.intp]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Columns and rows of each ray's `sample`s (n, m) in fixed point."""
    start, step = (np.floor(a * float(ONE)).astype(np.int64) for a in (rays.start, rays.direction))
    return start[:, 0, None] + sample * step[:, 0, None], start[:, 1, None] + sample * step[:, 1, None]

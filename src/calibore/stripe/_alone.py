"""Peaks that are not looked at again, each fitted on its own, as `native/src/stripe/alone.rs`."""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import ScanSettings
from calibore.stripe._picture import Picture, bilinear, inside_of
from calibore.stripe._rays import Rays
from calibore.stripe._scan import described

Array = NDArray[np.float64]


def alone(
    picture: Picture, rays: Rays, position: Array, left: NDArray[np.bool_], settings: ScanSettings
) -> tuple[Array, Array]:
    """Place and u (n,) [px] of the peaks at `position` (n,), those `left` (n,) moved by one weighted Gauss-Newton step
    from their own place and height; NaN where there is none.
    """
    plane = picture.plane()
    samples = bilinear(plane, rays, inside_of(plane, rays))
    place, u = position.copy(), np.full(position.size, np.nan)
    for ray in np.flatnonzero(left & np.isfinite(position)):
        peak = described(samples[ray], float(position[ray]), 0.0, settings)
        if peak is not None:
            place[ray], u[ray] = peak[0], peak[4]
    return place, u

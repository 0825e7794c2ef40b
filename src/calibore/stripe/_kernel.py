"""Which kernel runs: the compiled one, or its NumPy twin where that is asked for.

"scalar" is the compiled one without the vector instructions of the machine: the same numbers, for comparison.
"""

from typing import Any

from calibore._native import detect_line, detect_ring
from calibore.errors import ImageError
from calibore.kernels import is_native
from calibore.stripe._estimators import Estimator
from calibore.stripe._features import freed_of_features
from calibore.stripe._noise import NoiseModel
from calibore.stripe._picture import Picture
from calibore.stripe._rays import columns, compass, rows
from calibore.stripe._stripe import Stripe
from calibore.stripe._twin import Annulus, line_numpy, ring_numpy

KERNELS = ("native", "scalar", "numpy")


def ring_by(kernel: str, picture: Picture, ring: Annulus, estimator: Estimator) -> Stripe:
    """The ring in `picture`, measured by `kernel`; raises ImageError where there is none."""
    if not is_native(kernel, known=KERNELS):
        return freed_of_features(ring_numpy(picture, ring, estimator))
    direction, place = compass(ring.count), (ring.centre, (ring.inner, ring.outer))
    how = int(estimator), kernel != "scalar"
    try:
        arrays, noise, scale, centre = detect_ring(picture.image, picture.band, *place, direction, ring.counted, *how)
    except ValueError as error:
        raise ImageError(str(error)) from None
    return as_stripe(direction, arrays, noise, scale, centre)


def as_stripe(direction: Any, arrays: Any, noise: Any, scale: float, centre: Any = None) -> Stripe:
    """What the compiled code has found on rays along `direction`."""
    u, v, u_position, status, height, correlation, confidence = arrays
    seen = u, v, direction, u_position, status, height, correlation
    return Stripe(*seen, NoiseModel(*noise), scale, centre, confidence)


def line_by(kernel: str, picture: Picture, estimator: Estimator, *, down: bool) -> Stripe:
    """The line across `picture`, or `down` it, measured by `kernel`."""
    if not is_native(kernel, known=KERNELS):
        return freed_of_features(line_numpy(picture, estimator, down=down))
    arrays, noise, scale = detect_line(picture.image, picture.band, int(estimator), down, kernel != "scalar")
    return as_stripe((rows if down else columns)(picture.image.shape).direction, arrays, noise, scale)

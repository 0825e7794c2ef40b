"""A line in an image: find it, centre the rays on it if it is a ring, measure it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.kernels import DEFAULT_KERNEL
from calibore.stripe._centre import in_sectors
from calibore.stripe._estimators import estimator_named
from calibore.stripe._kernel import line_by, ring_by
from calibore.stripe._picture import prepare
from calibore.stripe._rays import check_annulus, compass
from calibore.stripe._stripe import Stripe
from calibore.stripe._twin import Annulus

RAYS = 1500
"""Along which a ring is looked for, unless another number is asked for."""
LEAST_RING = 0.05
"""A ring must be seen on at least this fraction of the rays."""


def detect_ring(
    image: NDArray[np.generic],
    centre: tuple[float, float],
    *,
    inner: float,
    outer: float,
    channel: str = "luma",
    rays: int = RAYS,
    estimator: str = "zero-crossing",
    sectors: Sequence[tuple[float, float]] | None = None,
    kernel: str = DEFAULT_KERNEL,
) -> Stripe:
    """The ring between `inner` and `outer` [px] about roughly `centre` (column, row) in `image` (h, w) or (h, w, 3).

    `image` is uint8 or uint16; `channel` "red", "green", "blue" or "luma" of a colour image; `estimator` see
    `estimator_named`; `sectors` image azimuths (from, to) [rad] used for centring, e.g. those without features, None
    uses all; `kernel` "native", "scalar" or "numpy". Raises ImageError where there is no ring, InputError or UsageError
    where an argument makes no sense.
    """
    picture = prepare(image, channel)
    place, inner, outer = (float(centre[0]), float(centre[1])), float(inner), float(outer)
    check_annulus(place, inner, outer, rays)
    ring = Annulus(place, inner, outer, rays, _counted(rays, sectors))
    stripe = ring_by(kernel, picture, ring, estimator_named(estimator))
    found = int(np.count_nonzero(stripe.found))
    if found < LEAST_RING * rays:
        raise ImageError(f"There is no laser ring in the image: a line was found on {found} of {rays} rays.")
    return stripe


def detect_line(
    image: NDArray[np.generic],
    *,
    down: bool = False,
    channel: str = "luma",
    estimator: str = "zero-crossing",
    kernel: str = DEFAULT_KERNEL,
) -> Stripe:
    """A line that crosses `image` from left to right, one peak per column; `u` are the columns, `v` the rows.

    `down`: the line runs down the image, one peak per row, as a side-facing head sees it. Other arguments as for
    `detect_ring`. A column or row without the line has a status and no value; no line at all is no error.
    """
    return line_by(kernel, prepare(image, channel), estimator_named(estimator), down=down)


def _counted(rays: int, sectors: Sequence[tuple[float, float]] | None) -> NDArray[np.bool_]:
    """Which rays (n,) lie in the alignment sectors."""
    if sectors is None:
        return np.ones(rays, dtype=bool)
    direction = compass(rays)
    return in_sectors(np.arctan2(direction[:, 1], direction[:, 0]), sectors)

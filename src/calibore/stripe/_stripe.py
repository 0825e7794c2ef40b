"""The lit line in one image."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.status import Status
from calibore.stripe._noise import NoiseModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stripe:
    """One line in one image, one point on each of n rays. NaN where `status` has no value.

    `u`, `v` (n,) [px] column and row of the points; `direction` (n, 2) unit vectors of the rays; `u_position` (n,) [px]
    standard uncertainty along the ray; `status` (n,) see `Status`; `height` (n,) [grey values] above the background;
    `correlation` (k,) of neighbouring points at lags 1 .. k rays; `noise` the noise model used; `scale` the observed
    over the modelled scatter, already contained in `u_position`; `centre` (column, row) [px] the rays start from, or
    None where they are not a ring's; `confidence` (n,) that the point lies on the wall, 0 to 1: the share of its light
    that the best path round the ring would lose without the chain of points that it belongs to, less for short chains.
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
    confidence: Array | None = None

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which points (n,) have a value: OK, RESOLVED or SATURATED."""
        return self.status <= int(Status.SATURATED)

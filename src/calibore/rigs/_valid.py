"""Where a calibration had points: beyond it, a rig only extrapolates."""

from dataclasses import dataclass

import numpy as np

from calibore.errors import InputError


@dataclass(frozen=True)
class ValidRegion:
    """`zenith` [rad] of camera rays and `radius` [m] (range of a side-facing head), from ... to; None: no limit."""

    zenith: tuple[float, float] | None = None
    radius: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("zenith", "radius"):
            limits = getattr(self, name)
            if limits is not None and not (np.isfinite(limits).all() and 0 <= limits[0] < limits[1]):
                raise InputError(f"The valid {name} goes from a smaller to a larger value, got {limits}.")

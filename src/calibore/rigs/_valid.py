"""Where a calibration had points: beyond it, a rig only extrapolates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError

Limits = tuple[float, float] | None
TOLERANCE = 0.02
"""Of the width of a region, on either side: as near its last point, a smooth function is as well known as at it."""
UNITS = {"mm": 1e-3, "in": 0.0254, "m": 1.0}


@dataclass(frozen=True)
class ValidRegion:
    """`zenith` [rad] of camera rays and `radius` [m] (range of a side-facing head), from ... to; None: no limit."""

    zenith: Limits = None
    radius: Limits = None

    def __post_init__(self) -> None:
        for name in ("zenith", "radius"):
            limits = getattr(self, name)
            if limits is not None and not (np.isfinite(limits).all() and 0 <= limits[0] < limits[1]):
                raise InputError(f"The valid {name} goes from a smaller to a larger value, got {limits}.")

    def holds(self, zenith: ArrayLike, radius: ArrayLike) -> NDArray[np.bool_]:
        """Which points (n,), seen at `zenith` [rad] and `radius` [m], lie inside, within `TOLERANCE`; NaN does not."""
        return _within(np.asarray(zenith), self.zenith) & _within(np.asarray(radius), self.radius)

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Zenith [rad] and radius [m] from ... to, `TOLERANCE` included; infinite where there is no limit."""
        return _widened(self.zenith), _widened(self.radius)

    def said(self, unit: str = "mm") -> str:
        """The region in words, radii in `unit` (mm, in or m); "" where it has no limits."""
        parts = []
        if self.zenith:
            parts.append(f"zenith {np.degrees(self.zenith[0]):.1f} to {np.degrees(self.zenith[1]):.1f} deg")
        if self.radius:
            low, high = (limit / UNITS[unit] for limit in self.radius)
            parts.append(f"radius {low:.4g} to {high:.4g} {unit}")
        return ", ".join(parts)


def _within(values: NDArray[np.float64], limits: Limits) -> NDArray[np.bool_]:
    if limits is None:
        return np.ones(values.shape, dtype=bool)
    least, most = _widened(limits)
    return (values >= least) & (values <= most)


def _widened(limits: Limits) -> tuple[float, float]:
    if limits is None:
        return -np.inf, np.inf
    slack = TOLERANCE * (limits[1] - limits[0])
    return limits[0] - slack, limits[1] + slack

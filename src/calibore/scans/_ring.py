"""One station of a scan: its profile on the clock grid and the ungridded points it was made from."""

from dataclasses import dataclass, field, fields
from math import nan

import numpy as np
from numpy.typing import NDArray

from calibore.status import Status, has_value

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RingProfile:
    """R(clock) of one station, n clock positions, m common modes; SI units.

    cov(radius) = diag(u_independent^2) + common_mode^T common_mode. Where nothing was measured `radius` is NaN and
    `status` says why. `correlation` (k,) is that of the independent part at lags of 1 .. k clock steps. `centre_x`,
    `centre_y` are the fitted pipe centre in the rig frame. Raises ValueError when shapes disagree, or when a status and
    its radius do.
    """

    station: int
    axial: float
    clock: Array
    radius: Array
    axial_position: Array
    u_independent: Array
    common_mode: Array
    status: NDArray[np.uint8]
    centre_x: float = nan
    centre_y: float = nan
    u_centre_x: float = nan
    u_centre_y: float = nan
    time_s: float = nan
    roll: float = nan
    correlation: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for name in ("clock", "radius", "axial_position", "u_independent", "common_mode", "correlation"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        object.__setattr__(self, "status", _statuses(self.status))
        n = self.clock.shape
        for name in ("radius", "axial_position", "u_independent", "status"):
            if len(n) != 1 or getattr(self, name).shape != n:
                raise ValueError(f"{name} must have the shape of clock {n}, got {getattr(self, name).shape}.")
        if self.common_mode.ndim != 2 or self.common_mode.shape[1:] != n:
            raise ValueError(f"common_mode must have shape (m, {n[0]}), got {self.common_mode.shape}.")
        _agree(self.radius, self.status)

    @property
    def u_common(self) -> Array:
        """Standard uncertainty shared by the whole scan, shape (n,) [m]: root of the sum of squares over modes."""
        return np.where(np.isnan(self.radius), np.nan, np.sqrt(np.sum(self.common_mode**2, axis=0)))


@dataclass(frozen=True)
class RingPoints:
    """The k ungridded points of one station, every field of shape (k,); SI units, `x, y, z` in the pipe frame.

    `u` and `v` are the pixel (column, row) as the contract names them; `u_radius` is the standard uncertainty of
    `radius` [m], which the contract also calls u. `take` is the image each point comes from.
    """

    x: Array
    y: Array
    z: Array
    radius: Array
    clock: Array
    axial: Array
    u_radius: Array
    u: Array
    v: Array
    take: NDArray[np.integer]
    status: NDArray[np.uint8]

    def __post_init__(self) -> None:
        for name in (column.name for column in fields(self)):
            kind = {"take": np.int64, "status": np.uint8}.get(name, np.float64)
            value = _statuses(self.status) if name == "status" else np.asarray(getattr(self, name), kind)
            object.__setattr__(self, name, value)
            if value.ndim != 1 or value.shape != self.x.shape:
                raise ValueError(f"{name} must have the shape of x {self.x.shape}, got {value.shape}.")
        _agree(self.radius, self.status)


def _statuses(values: NDArray[np.integer]) -> NDArray[np.uint8]:
    values = np.asarray(values)
    if values.size and not (values.min() >= 0 and values.max() <= max(Status)):
        raise ValueError(f"A status must be one of {[int(status) for status in Status]}, got {values.max()}.")
    return values.astype(np.uint8)


def _agree(radius: Array, status: NDArray[np.uint8]) -> None:
    wrong = np.flatnonzero(np.isfinite(radius) != has_value(status))
    if wrong.size:
        first = wrong[0]
        raise ValueError(
            f"Point {first} has radius {radius[first]:g} m with status {Status(status[first]).name}; "
            "a point has a finite radius exactly when its status carries a value."
        )

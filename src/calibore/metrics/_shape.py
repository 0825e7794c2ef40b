"""What the ring quantities are computed from: one ring of radii with their uncertainty."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

MOST = 1e6  # [m] or [rad] beyond any pipe, and its square is still a number
LEAST_POWER = 0.02  # 1 + 2 sum of the autocorrelation


@dataclass(frozen=True, eq=False)
class RingShape:
    """Radii of one ring about the rig axis, n clock positions, m common modes.

    clock (n,) [rad]: increasing, within one turn. radius (n,) [m]: NaN where nothing was measured.
    u_independent (n,) [m]: standard uncertainty that differs from point to point. common_mode (m, n) [m]: the part all
    points share, in low rank. correlation (k,): autocorrelation of the independent part at lags of 1..k clock steps.
    cov(radius) = diag(u) C diag(u) + common_mode^T common_mode, C the correlation matrix. Values at missing radii are
    ignored. Raises InputError where shapes disagree or values are impossible.
    """

    clock: Array
    radius: Array
    u_independent: Array
    common_mode: Array = field(default_factory=lambda: np.empty((0, 0)))
    correlation: Array = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        for name in ("clock", "radius", "u_independent", "common_mode", "correlation"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        if self.common_mode.size == 0:
            object.__setattr__(self, "common_mode", np.empty((0, self.clock.size)))
        self._check_shapes()
        self._check_values()

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Shape (n,): where a radius was measured."""
        return np.isfinite(self.radius)

    def _check_shapes(self) -> None:
        n = self.clock.size
        if self.clock.shape != (n,) or n < 4:
            raise InputError(f"clock of a ring must have shape (n,) with n >= 4, got {self.clock.shape}.")
        for name in ("radius", "u_independent"):
            if getattr(self, name).shape != (n,):
                raise InputError(f"{name} must have the shape of clock ({n},), got {getattr(self, name).shape}.")
        if self.common_mode.ndim != 2 or self.common_mode.shape[1] != n:
            raise InputError(f"common_mode must have shape (m, {n}), got {self.common_mode.shape}.")
        if self.correlation.ndim != 1 or self.correlation.size >= n / 4:
            raise InputError(f"correlation must have shape (k,) with k < {n / 4:g}, got {self.correlation.shape}.")

    def _check_values(self) -> None:
        measured = self.measured
        clock = self.clock
        if not ((np.abs(clock) <= MOST).all() and (np.diff(clock) > 0).all() and np.ptp(clock) < 2 * np.pi):
            raise InputError("clock of a ring must increase and stay within one turn (2 pi rad); sort the points.")
        radius = self.radius[measured]
        if np.isinf(self.radius).any() or not ((radius >= 1 / MOST) & (radius <= MOST)).all():
            raise InputError("radius must be positive and that of a pipe [m], or NaN where nothing was measured.")
        sigma = self.u_independent[measured]
        if not ((sigma >= 0) & (sigma <= MOST)).all():
            raise InputError("u_independent must be finite and not negative [m] wherever radius is measured.")
        if not (np.abs(self.common_mode[:, measured]) <= MOST).all():
            raise InputError("common_mode must be finite [m] wherever radius is measured.")
        if not (np.abs(self.correlation) <= 1).all():
            raise InputError("correlation must lie between -1 and 1 at every lag.")
        power = 1 + 2 * float(self.correlation.sum())
        if power < LEAST_POWER:
            raise InputError(
                f"correlation gives the mean of many points the variance {power:g} / n; it must be above "
                f"{LEAST_POWER:g} / n. Give fewer lags, or those of a measured autocorrelation."
            )

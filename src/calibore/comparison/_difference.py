"""The difference of two registered profiles, point by point, and how well it is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.registration import RIGID, Motion, Registration, register
from calibore.scans import Profile

Array = NDArray[np.float64]
LEAST_SCATTER = 0.8
"""Of what both profiles state: by chance residuals scatter less than that only where little is compared."""


@dataclass(frozen=True, eq=False)
class Difference:
    """Of the radius, moved profile minus reference, on the moved profile's grid (n, m), NaN where either lacks.

    `axial` [m] and `clock` [rad] (n, m): where its points lie on the reference; `radius` (n, m) [m] moved. `value` (n,
    m) [m]: its noise `u_independent` of both (n, m), calibration of both and alignment `modes` (k, n, m), and `missed`
    (n, m): a standard deviation of what lies between the points of either and beside edges, alike for neighbours.

    `adjusted` (n, m) is `value` without what calibration errors of both, as they suit best, explain: what is left is
    the wall's. Its common part is `adjusted_modes`.
    """

    registration: Registration
    axial: Array
    clock: Array
    radius: Array
    value: Array
    u_independent: Array
    missed: Array
    modes: Array
    adjusted: Array
    adjusted_modes: Array

    @property
    def u(self) -> Array:
        """Standard uncertainty (n, m) [m] of `value`."""
        return np.sqrt(self.u_independent**2 + self.missed**2 + np.sum(self.modes**2, axis=0))

    @property
    def u_adjusted(self) -> Array:
        """Standard uncertainty (n, m) [m] of `adjusted`; noise counts as it was observed."""
        noise = self.u_independent * max(self.registration.scatter, LEAST_SCATTER)
        return np.sqrt(noise**2 + self.missed**2 + np.sum(self.adjusted_modes**2, axis=0))


def difference(
    moving: Profile,
    reference: Profile,
    *,
    free: Sequence[str] = RIGID,
    start: Motion | None = None,
    per_ring: bool = False,
    search: bool = True,
) -> Difference:
    """Registers `moving` to `reference` (arguments as of `registration.register`) and takes the difference.

    Raises InputError where the two cannot be brought together.
    """
    registration = register(moving, reference, free=free, start=start, per_ring=per_ring, search=search)
    return difference_of(registration, moving.radius.shape)


def difference_of(registration: Registration, shape: tuple[int, int]) -> Difference:
    """After a registration; `shape` (n, m) of the moved profile."""
    gaps, cloud = registration.gaps, registration.cloud

    def grid(values: Array) -> Array:
        whole = np.full((*values.shape[:-1], *shape), np.nan)
        whole[..., cloud.ring, cloud.position] = values
        return whole

    table, before, after = _common(registration)
    explained = gaps.modes.T @ registration.modes if len(gaps.modes) else np.zeros(gaps.residual.size)
    gone = np.where(np.isfinite(gaps.residual), 0.0, np.nan)
    return Difference(
        registration,
        axial=grid(gaps.axial),
        clock=grid(gaps.clock),
        radius=grid(gaps.radius),
        value=grid(-gaps.residual),
        u_independent=grid(np.sqrt(gaps.variance)),
        missed=_on_flanks(grid(gaps.missed + gone)),
        modes=grid((table @ before).T + gone),
        adjusted=grid(-gaps.residual - explained),
        adjusted_modes=grid((table @ after).T + gone),
    )


def _on_flanks(missed: Array) -> Array:
    """(n, m) no less than on both sides: on the flank of a feature a bend turns into its opposite, and is none just
    where the flank is steepest.
    """
    whole = np.nan_to_num(missed)
    return np.maximum(missed, np.minimum(np.roll(whole, 1, axis=1), np.roll(whole, -1, axis=1)))


def _common(registration: Registration) -> tuple[Array, Array, Array]:
    """Slopes (p, s) of the residuals by what was solved for, and roots of covariances: of alignment errors together
    with the calibration errors themselves, and of what is left of both once they are estimated.
    """
    table = registration.table
    joint = registration.joint
    solved = len(joint) - len(registration.modes)
    total = joint.copy()
    total[:solved, solved:] *= -1
    total[solved:, :solved] *= -1
    total[solved:, solved:] = np.eye(len(registration.modes))
    return table, _root(total), _root(joint)


def _root(matrix: Array) -> Array:
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2 / _scales(matrix))
    kept = values > 0
    return np.sqrt(np.diag(matrix))[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def _scales(matrix: Array) -> Array:
    u = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return np.outer(u, u)

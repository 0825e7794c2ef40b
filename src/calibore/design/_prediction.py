"""How well a rig measures, told before it is built: R, H and their uncertainties at pixels and at places of a wall."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.design._assumptions import Direction
from calibore.errors import InputError
from calibore.rigs import Rig, SideFacing, lit_points, margin, triangulate
from calibore.status import Status
from calibore.uncertainty import MEASURABLE_ABOVE, Covariance, budget, propagate

Array = NDArray[np.float64]
EDGE = 1e-6  # px, of rounding
STRIPE = "stripe"
"""The name under which the noise of the line position stands in a budget."""


@dataclass(frozen=True, eq=False)
class Part:
    """Of one coordinate, arrays like the pixels [m]: standard uncertainty `u`, its `independent` and `common` part,
    `modes` (m, ...) of the common one, and `shares` of the variance by input, noise included (sum 1, correlated
    inputs of either sign).
    """

    u: Array
    independent: Array
    common: Array
    modes: Array
    shares: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Prediction:
    """Arrays of one shape: pixel `u`, `v`; `radius`, `axial` [m], `clock` [rad]; the `margin` of first order; `status`;
    `branch` of the surface; `in_image`. Uncertainties in `of_radius` and `of_axial`.
    """

    u: Array
    v: Array
    radius: Array
    axial: Array
    clock: Array
    of_radius: Part
    of_axial: Part
    margin: Array
    status: NDArray[np.uint8]
    branch: NDArray[np.intp]
    in_image: NDArray[np.bool_]

    @property
    def u_radius(self) -> Array:
        """Standard uncertainty [m]."""
        return self.of_radius.u

    @property
    def u_axial(self) -> Array:
        """Standard uncertainty [m]."""
        return self.of_axial.u

    @property
    def u_radius_independent(self) -> Array:
        return self.of_radius.independent

    @property
    def u_radius_common(self) -> Array:
        return self.of_radius.common

    @property
    def shares(self) -> Mapping[str, Array]:
        """Of the variance of the radius, by input."""
        return self.of_radius.shares

    @property
    def measurable(self) -> NDArray[np.bool_]:
        """Seen, met, and farther from the frontier than one standard uncertainty."""
        return self.in_image & (self.status == Status.OK) & (self.margin > MEASURABLE_ABOVE)


def scan_direction(rig: Rig, u: ArrayLike, v: ArrayLike) -> Array:
    """(..., 2) unit vectors along which a line is looked for: outwards from the principal point; along u for a
    side-facing head.
    """
    u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
    if isinstance(rig.mount, SideFacing):
        return np.stack([np.ones(u.shape), np.zeros(u.shape)], axis=-1)
    x, y = u - rig.camera.principal_point[0], v - rig.camera.principal_point[1]
    length = np.hypot(x, y)
    safe = np.where(length > 0, length, 1.0)
    return np.stack([np.where(length > 0, x / safe, 1.0), y / safe], axis=-1)


def predict(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    u_pixel: float = 1.0,
    direction: Direction = "scan",
    laser: int = 0,
    prior_radius: ArrayLike | None = None,
    branch: ArrayLike | None = None,
) -> Prediction:
    """R and H at pixels `u`, `v` of any shape, with first-order uncertainties from the rig's covariance and `u_pixel`
    [px] of noise along `direction`; `prior_radius` [m] or `branch` chooses among two meetings, as in `triangulate`.
    """
    if not 0 <= u_pixel < np.inf:
        raise InputError(f"The noise of a line position must be 0 or more, got {u_pixel} px; give its absolute value.")
    u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
    shape = u.shape
    flat = u.ravel(), v.ravel()
    prior, chosen = (None if a is None else np.broadcast_to(a, shape).ravel() for a in (prior_radius, branch))
    along = _along(rig, *flat, direction)
    found = triangulate(rig, *flat, laser=laser, prior_radius=prior, branch=chosen)
    safety = margin(rig, *flat, branch=found.branch, u_pixel=u_pixel, direction=along, laser=laser)
    safety = np.where(found.status == Status.OK, safety, np.nan)
    known = rig.covariance or Covariance.independent({})

    def part(coordinate: Any) -> Part:
        noise = _noise(coordinate.pixel, along) * u_pixel
        return _part(coordinate.parameters, known, rig.parameter_names, noise, shape)

    return Prediction(
        u=u,
        v=v,
        radius=found.radius.reshape(shape),
        axial=found.axial.reshape(shape),
        clock=found.clock.reshape(shape),
        of_radius=part(found.radius_sensitivities),
        of_axial=part(found.axial_sensitivities),
        margin=safety.reshape(shape),
        status=found.status.reshape(shape),
        branch=found.branch.reshape(shape),
        in_image=in_image(rig, u, v),
    )


def predict_on_wall(
    rig: Rig,
    clock: ArrayLike,
    radius: ArrayLike,
    *,
    axial: ArrayLike = 0.0,
    u_pixel: float = 1.0,
    direction: Direction = "scan",
    laser: int = 0,
) -> Prediction:
    """At the places of round walls of `radius` [m] that `laser` lights at `clock` [rad], with the meeting that belongs
    to the wall; NaN where no light falls or the lens does not see it.

    `axial` [m]: place along the sheet of a side-facing head, whose frame is turned to the clock.
    """
    clock, radius, axial = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (clock, radius, axial)))
    points = lit_points(rig, clock, radius, laser=laser, axial=axial)
    u, v = (a.reshape(clock.shape) for a in rig.project(points))
    return predict(rig, u, v, u_pixel=u_pixel, direction=direction, laser=laser, prior_radius=radius)


def in_image(rig: Rig, u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
    """Whether the pixels lie in the image, which the fields of view of the source count from 0 to its width."""
    u, v = np.asarray(u), np.asarray(v)
    camera = rig.camera
    rows = (v >= -EDGE) & (v <= camera.height + EDGE)
    if camera.height == 1:
        rows = np.abs(v - camera.principal_point[1]) <= 1
    return (u >= -EDGE) & (u <= camera.width + EDGE) & rows


def _along(rig: Rig, u: Array, v: Array, direction: Direction) -> Array | None:
    if direction is None:
        return None
    if isinstance(direction, str):
        return scan_direction(rig, u, v)
    return np.broadcast_to(direction, (*np.shape(direction)[:-1], 2)).reshape(-1, 2)


def _noise(by_pixel: Array, along: Array | None) -> Array:
    """(n,) derivative by one pixel of noise."""
    if along is None:
        return np.sqrt(np.einsum("nk,nk->n", by_pixel, by_pixel))
    return np.abs(np.einsum("nk,nk->n", by_pixel, along))


def _part(
    sensitivities: Array, known: Covariance, names: tuple[str, ...], noise: Array, shape: tuple[int, ...]
) -> Part:
    modes, common = propagate(sensitivities, known, names=names)
    parts = budget(sensitivities, known, names=names, independent={STRIPE: noise})
    total = parts.variances.sum(axis=1)
    safe = np.where(total > 0, total, 1.0)
    return Part(
        u=np.hypot(noise, common).reshape(shape),
        independent=noise.reshape(shape),
        common=common.reshape(shape),
        modes=modes.reshape(-1, *shape),
        shares={name: (parts.variances[:, i] / safe).reshape(shape) for i, name in enumerate(parts.names)},
    )

"""A circle fitted by orthogonal distances, with its covariance."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry._orthogonal import distances_with_jacobian, least_squares_circle
from calibore.geometry._robust_circle import TUKEY_EFFICIENCY, robust_circle

Array = NDArray[Any]

COLLINEAR = 1e-14  # (thickness / length)^2 of the point set below which it is a line


@dataclass(frozen=True, eq=False)
class CircleFit:
    """`covariance` (3, 3) of (centre x, centre y, radius), absolute where `sigma` was given, otherwise scaled by the
    residual variance (NaN without a spare point). `residuals` (n,): distance from the circle, positive outside; NaN
    for points that were not finite. `inliers` (n,): points that carried weight.
    """

    centre: Array
    radius: float
    covariance: Array
    inliers: NDArray[np.bool_]
    residuals: Array
    degrees_of_freedom: int

    @property
    def u_centre(self) -> Array:
        """Standard uncertainties (2,) of the centre."""
        return np.sqrt(np.diag(self.covariance)[:2])

    @property
    def u_radius(self) -> float:
        return float(np.sqrt(self.covariance[2, 2]))


def fit_circle(points: ArrayLike, *, sigma: ArrayLike | None = None, robust: bool = False) -> CircleFit:
    """The circle with the least sum of squared orthogonal distances to `points` (n, 2); rows with NaN are left out.

    `sigma` (n,) or one number: standard uncertainty of each distance, in the unit of the points. With `robust` the fit
    starts from the least median of squares and is re-weighted (Tukey), so that features or foreign points on up to
    40 % of the ring do not pull it. Raises InputError where the points determine no circle.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"Circle points must have shape (n, 2), got {points.shape}.")
    used = np.asarray(np.isfinite(points).all(axis=1))
    scaled, mean, extent = _scaled(points[used])
    weights = _weights(sigma, used, extent)
    if robust:
        circle, carried, variance = robust_circle(scaled, weights)
    else:
        circle, carried, variance = least_squares_circle(scaled, weights), np.ones(len(scaled), dtype=bool), np.nan
    distances, jacobian = distances_with_jacobian(circle, scaled)
    spare = int(carried.sum()) - 3
    if sigma is not None:
        variance = 1.0 / TUKEY_EFFICIENCY if robust else 1.0
    elif spare and not robust:
        variance = float(weights @ distances**2) / spare
    normal = (jacobian[carried].T * weights[carried]) @ jacobian[carried]
    inliers, residuals = np.zeros(len(points), dtype=bool), np.full(len(points), np.nan)
    inliers[used], residuals[used] = carried, distances * extent
    return CircleFit(
        centre=circle[:2] * extent + mean,
        radius=float(circle[2] * extent),
        covariance=variance * np.linalg.inv(normal) * extent**2,
        inliers=inliers,
        residuals=residuals,
        degrees_of_freedom=spare,
    )


def _scaled(points: Array) -> tuple[Array, Array, float]:
    """The points about their mean with unit extent, where rounding is smallest; the mean; the extent."""
    if len(points) < 3:
        raise InputError(f"A circle needs at least 3 points, got {len(points)} finite ones; add points.")
    mean = points.mean(axis=0)
    centred = points - mean
    narrow, wide = np.linalg.eigvalsh(centred.T @ centred)
    if not narrow > COLLINEAR * wide:
        raise InputError(f"The {len(points)} points lie on one line, which determines no circle; add points off it.")
    extent = float(np.abs(centred).max())
    return centred / extent, mean, extent


def _weights(sigma: ArrayLike | None, used: NDArray[np.bool_], extent: float) -> Array:
    """Inverse variances (n,) in the scaled frame; 1 without `sigma`."""
    if sigma is None:
        return np.ones(int(used.sum()))
    sigma = np.broadcast_to(np.asarray(sigma, dtype=float), used.shape)[used]
    if not (np.isfinite(sigma).all() and (sigma > 0).all()):
        raise InputError("sigma of a circle fit must be positive and finite; leave it out for equal weights.")
    return (extent / sigma) ** 2

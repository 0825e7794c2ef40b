"""Generalised least squares of a Gaussian line on many rays, as `native/src/stripe/generalised.rs`."""

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._noise import NoiseModel
from calibore.stripe._refine import SINGULAR
from calibore.stripe._windows import Windows

Array = NDArray[np.float64]


def generalised_step(windows: Windows, height: Array, noise: NoiseModel, *, aside: float = 0.0) -> tuple[Array, Array]:
    """Step (n,) [px] from where n rays are looked at to the line, and its standard uncertainty (n,) [px].

    One Gauss-Newton step of `height` (n,) exp(-distance^2 / 2 width^2) + background in place, height and background,
    the samples weighted by the inverse of their covariance: noise of the sensor and correlated speckle. So the variance
    is the inverse Fisher information. Seen from `aside` [px] of the places. NaN where the samples fix no place.

    For the weights alone the height is rounded to a power of two: the optimum is flat, and many rays share them.
    """
    known = np.isfinite(windows.value) & (height > 0)[:, None]
    height = np.where(height > 0, height, 1.0)
    usual = np.exp2(np.floor(np.log2(height) + 0.5))[:, None]
    distance, square = windows.distance + aside, windows.width[:, None] ** 2
    bell = np.where(known, np.exp(-(distance**2) / (2 * square)), 0.0)
    number = np.arange(distance.shape[1])
    apart = np.abs(number[:, None] - number) * windows.apart
    covariance = noise.contrast * bell[:, :, None] * bell[:, None, :] * np.exp(-(apart**2) / (4 * noise.grain**2))
    covariance[:, number, number] += np.where(known, (noise.additive / usual + noise.gain * bell) / usual, 1.0)
    jacobian = np.stack([bell * distance / square, bell, known * 1.0], axis=2)
    weighted = np.linalg.solve(covariance, jacobian)
    normal = np.swapaxes(jacobian, 1, 2) @ weighted
    fixed = np.linalg.det(normal) > SINGULAR * np.prod(np.diagonal(normal, axis1=1, axis2=2), axis=1)
    inverse = np.linalg.inv(np.where(fixed[:, None, None], normal, np.eye(3)))[:, 0]
    functional = np.einsum("nk,nmk->nm", inverse, weighted) * known
    moved = np.sum(functional * np.where(known, windows.value, 0.0), axis=1) / height
    low, usual = 1 / height, 1 / usual[:, 0]
    more = noise.additive * (low**2 - usual**2) * np.sum(functional**2, axis=1)
    more += noise.gain * (low - usual) * np.sum(functional**2 * bell, axis=1)
    u = np.sqrt(np.maximum(inverse[:, 0] + more, 0.0))
    return np.where(fixed, moved, np.nan), np.where(fixed, u, np.nan)

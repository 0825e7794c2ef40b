"""What a Jacobian determines: singular values of its scaled columns."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DETERMINED = 1e-10
"""Smallest singular value, relative to the largest, of scaled columns: below it lies what rounding leaves."""

TAKES_PART = 1e-6
"""Component of a direction, of length 1 in scaled parameters, above which a parameter belongs to it."""


class Spectrum(NamedTuple):
    """`scale` (p,) of the columns, 1 of empty ones; `values` (p,) singular values of the columns divided by it, largest
    first; `axes` (p, p) in the scaled parameters, one in each row; `rank`.
    """

    scale: Array
    values: Array
    axes: Array
    rank: int

    @property
    def basis(self) -> Array:
        """Directions (p, rank) of the parameters in which the Jacobian's columns are orthonormal."""
        return (self.axes[: self.rank].T / self.values[: self.rank]) / self.scale[:, None]

    @property
    def confounded(self) -> NDArray[np.bool_]:
        """Elements (p, p) of the covariance that are without bound: of pairs in a direction that changes nothing."""
        free = np.abs(self.axes[self.rank :]) > TAKES_PART
        return np.asarray((free[:, :, None] & free[:, None, :]).any(axis=0))


def triangle(jacobian: Array) -> Array:
    """R (p, p) of the QR decomposition of `jacobian` (n, p)."""
    root = np.linalg.qr(jacobian, mode="r")
    return np.concatenate([root, np.zeros((jacobian.shape[1] - len(root), jacobian.shape[1]))])


def spectrum(root: Array) -> Spectrum:
    scale = np.linalg.norm(root, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, values, axes = np.linalg.svd(root / scale)
    return Spectrum(scale, values, axes, int(np.sum(values > DETERMINED * values[0])))

"""Where a camera images the area of a dot, against the image of its centre."""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate
from calibore.calibration._boards._data import BoardData, rotations

Array = NDArray[np.float64]

RIM = 24  # points on the rim: their polygon has the disc's centroid within 1e-3 of the shift


def dot_shift(data: BoardData, estimate: Estimate, diameter: float) -> Array:
    """Centroid of the image of each dot of `diameter` [m] minus the image of its centre (n, 2) [px]; NaN of dots that
    are not imaged whole.
    """
    points, _ = data.points(estimate.poses, estimate.bends)
    turn = 2 * np.pi * np.arange(RIM) / RIM
    rim = diameter / 2 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    turned = np.einsum("mij,kj->mki", rotations(estimate.poses[:, :3]), rim)[data.owner]
    u, v = (part.reshape(-1, RIM) for part in estimate.camera.project((points[:, None] + turned).reshape(-1, 3)))
    centre = np.stack(estimate.camera.project(points), axis=1)
    x, y = u - centre[:, :1], v - centre[:, 1:]
    after_x, after_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    area = x * after_y - after_x * y
    return np.stack([((x + after_x) * area).sum(axis=1), ((y + after_y) * area).sum(axis=1)], axis=1) / (
        3 * area.sum(axis=1, keepdims=True)
    )

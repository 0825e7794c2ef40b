"""scikit-image unwraps the annulus; the parabola is the same vectorised NumPy as that of the OpenCV peer."""

import numpy as np
from skimage.transform import warp_polar

from benchmarks.peers.opencv_warp_polar import RAYS


def unwrap(plane: np.ndarray, centre: tuple[float, float], inner: float, outer: float) -> np.ndarray:
    """(rays, samples) float32, one pixel apart from `inner` to `outer`, bilinear."""
    samples = int(np.ceil(outer))
    polar = warp_polar(
        plane, (centre[1], centre[0]), radius=samples, output_shape=(RAYS, samples), order=1, preserve_range=True
    )
    return polar[:, int(inner) :].astype(np.float32)

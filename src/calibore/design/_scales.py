"""The scales k that a camera choice allows, and what a lens makes of zeniths."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.design._requirement import CameraChoice
from calibore.optics import Lens

Array = NDArray[np.float64]


class Scales(NamedTuple):
    """`fixed` (n,) [px], or every k from `least` to `most`."""

    fixed: Array | None
    least: float
    most: float

    def among(self, wished: Array) -> Array:
        """What there is of the `wished` scales: the fixed ones, or those moved into the range."""
        if self.fixed is not None:
            return self.fixed
        return np.unique(np.clip(wished[np.isfinite(wished)], self.least, self.most))


def scales_of(camera: CameraChoice, lens: str) -> Scales:
    """From k itself, or from the whole field of view across the longer side; empty where the lens cannot have it."""
    if camera.k:
        return Scales(np.array(camera.k), 0.0, np.inf)
    if camera.k_range:
        return Scales(None, *camera.k_range)
    side = max(camera.width, camera.height) / 2
    if camera.field_of_view:
        k = side / Lens(lens, 1.0, 1.0).image_radius(np.array(camera.field_of_view) / 2)
        return Scales(k[np.isfinite(k)], 0.0, np.inf)
    if camera.field_of_view_range:
        narrow, wide = side / Lens(lens, 1.0, 1.0).image_radius(np.array(camera.field_of_view_range) / 2)
        return Scales(None, 0.0 if np.isnan(wide) else float(wide), float(narrow))
    return Scales(None, 0.0, np.inf)


def image_of(lens: str, zenith: Array) -> tuple[Array, Array]:
    """Image radius and its slope by the zenith, both for k = 1; NaN where the lens images nothing."""
    unit = Lens(lens, 1.0, 1.0)
    radius = unit.image_radius(zenith)
    return radius, 1 / unit.zenith_with_sensitivities(radius)[1]

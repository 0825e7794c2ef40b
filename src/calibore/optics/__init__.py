"""From pixel to camera ray and back: lens laws, residual distortion, camera.

`LENS_LAWS`  the laws r = k f(zenith) by name
`Lens`       a law with its k [px] and radial residual
`Camera`     a lens on a sensor: `unproject` (pixel to ray, with sensitivities) and `project` (point to pixel)
"""

from calibore.optics._camera import Camera
from calibore.optics._laws import LENS_LAWS, LENS_NAMES, LensLaw, polynomial_law
from calibore.optics._lens import Lens

__all__ = ["LENS_LAWS", "LENS_NAMES", "Camera", "Lens", "LensLaw", "polynomial_law"]

"""From pixel to camera ray and back: lens laws, residual distortion, camera.

`LENS_LAWS`  the laws r = k f(zenith) by name
`Lens`       a law with its k [px] and radial residual
`Camera`     a lens on a sensor: `unproject` (pixel to ray) and `project` (point to pixel), both with sensitivities
`Projection` where points fall in the image, and what moves those places
`FlatPort`   a window between the camera and the scene
`Rays`       where camera rays start and go; `RaysWithSensitivities` also says what moves them
"""

from calibore.optics._camera import Camera
from calibore.optics._laws import LENS_LAWS, LENS_NAMES, LensLaw, polynomial_law
from calibore.optics._lens import Lens
from calibore.optics._port import FlatPort
from calibore.optics._projection import Projection
from calibore.optics._rays import Rays, RaysWithSensitivities

__all__ = [
    "LENS_LAWS",
    "LENS_NAMES",
    "Camera",
    "FlatPort",
    "Lens",
    "LensLaw",
    "Projection",
    "Rays",
    "RaysWithSensitivities",
    "polynomial_law",
]

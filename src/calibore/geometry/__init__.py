"""Frames, angles and fits that know nothing of cameras or lasers.

`clock_of`, `xy_of`  the one place where clock positions and coordinates meet
`Pose`               a rigid motion, named `a_from_b`
`fit_circle`         a circle by orthogonal distances, with covariance, robust on request
"""

from calibore.geometry._circle import CircleFit, fit_circle
from calibore.geometry._clock import clock_of, xy_of
from calibore.geometry._pose import Pose

__all__ = ["CircleFit", "Pose", "clock_of", "fit_circle", "xy_of"]

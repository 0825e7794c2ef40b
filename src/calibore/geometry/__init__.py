"""Frames, angles and fits that know nothing of cameras or lasers.

`clock_of`, `xy_of`  the one place where clock positions and coordinates meet
`Pose`               a rigid motion, named `a_from_b`
`fit_circle`         a circle by orthogonal distances, with covariance, robust on request
`drawn_triples`      the triples of points that its robust start tries, for those who compute it elsewhere
"""

from calibore.geometry._circle import CircleFit, fit_circle
from calibore.geometry._clock import clock_of, xy_of
from calibore.geometry._pose import Pose
from calibore.geometry._robust_circle import drawn_triples

__all__ = ["CircleFit", "Pose", "clock_of", "drawn_triples", "fit_circle", "xy_of"]

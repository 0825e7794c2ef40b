"""Two profiles of one pipe in one frame: by which motion, and how well it is known.

`register`      `Motion` of a moving profile onto a reference, automatic, robust, with covariance -> `Registration`
`Surface`       the reference between its points, with what is not known there
`AstrayError`   raised where the best motion has slid off the wall: no common shape
`rotated`       one ring turned by a fraction of clock positions, as in the dissertation (eq. 8-3)
"""

from calibore.registration._astray import AstrayError
from calibore.registration._gaps import Cloud, Gaps, gaps
from calibore.registration._motion import Motion
from calibore.registration._register import RIGID, Registration, register
from calibore.registration._rotated import rotated
from calibore.registration._surface import Place, Surface

__all__ = [
    "RIGID",
    "AstrayError",
    "Cloud",
    "Gaps",
    "Motion",
    "Place",
    "Registration",
    "Surface",
    "gaps",
    "register",
    "rotated",
]

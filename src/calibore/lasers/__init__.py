"""Laser surfaces F(x; q) = 0 and where camera rays meet them.

`LaserSurface`  what every surface can do: value, gradient, parameter gradient, meet, frontier
`Plane`         the (tilted) perpendicular plane
`Cone`          single, dual, coaxial, asymmetric and reversed cones; `ring_angles` of the cone that lights a given ring
`Sheet`         the sheet of a side-facing head
`Beam`          one beam of a spot array
`Meetings`      distances along the rays with `MeetingFlag`s
`Frontier`      how far a ray is from losing its meetings
"""

from calibore.lasers._beam import Beam
from calibore.lasers._cone import Cone
from calibore.lasers._plane import Plane
from calibore.lasers._ring_angles import ring_angles
from calibore.lasers._sheet import Sheet
from calibore.lasers._surface import GRAZING_SINE, Frontier, LaserSurface, MeetingFlag, Meetings

__all__ = [
    "GRAZING_SINE",
    "Beam",
    "Cone",
    "Frontier",
    "LaserSurface",
    "MeetingFlag",
    "Meetings",
    "Plane",
    "Sheet",
    "ring_angles",
]

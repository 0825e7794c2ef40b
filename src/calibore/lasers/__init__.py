"""Laser surfaces F(x; q) = 0 and where camera rays meet them.

`LaserSurface`  what every surface can do: value, gradient, parameter gradient, meet
`Plane`         the (tilted) perpendicular plane
`Meetings`      distances along the rays with `MeetingFlag`s
"""

from calibore.lasers._plane import Plane
from calibore.lasers._surface import GRAZING_SINE, LaserSurface, MeetingFlag, Meetings

__all__ = ["GRAZING_SINE", "LaserSurface", "MeetingFlag", "Meetings", "Plane"]

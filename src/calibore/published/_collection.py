"""The tables and figures that can be drawn anew, in the order of the source."""

from collections.abc import Callable

from calibore.published import _cone_angles as angles
from calibore.published import _cone_maps as maps
from calibore.published import _cone_profiles as profiles
from calibore.published import _cone_roots as roots
from calibore.published import _plane_pictures as plane
from calibore.published import _side_pictures as side
from calibore.published._occlusion import figure_4_5
from calibore.published._pictures import Picture

PICTURES: tuple[Callable[[], Picture], ...] = (
    angles.figure_3_3,
    angles.figure_3_4,
    roots.figure_3_10,
    roots.figure_3_11,
    roots.figure_3_12,
    maps.table_3_1,
    maps.table_3_2,
    angles.figure_3_15,
    angles.figure_3_16,
    maps.table_3_3,
    profiles.figure_3_17,
    profiles.figure_3_19,
    profiles.figure_3_20,
    profiles.figure_3_21,
    profiles.figure_3_22,
    profiles.figure_3_23,
    plane.table_4_1,
    plane.table_4_2,
    plane.figure_4_3,
    plane.figure_4_4,
    figure_4_5,
    plane.figure_4_6,
    side.table_5_1,
    side.figure_5_3,
    side.figure_5_4,
    side.table_5_2,
    side.figure_5_5,
    side.figure_5_6,
)
"""Without the photographs, sketches of the set-up and axes that show no result of a computation."""

"""The configurations a rig file may name: which laser table each has, and how many of them."""

from dataclasses import dataclass

from calibore.lasers import Beam, Cone, LaserSurface, Plane, Sheet


@dataclass(frozen=True)
class Configuration:
    """`surface` of every laser; `lasers` = (fewest, most or None); `fixed` keys with the only value they may have;
    `side_facing`: the camera stands on a rotating head.
    """

    surface: type[LaserSurface]
    lasers: tuple[int, int | None] = (1, 1)
    side_facing: bool = False
    fixed: tuple[tuple[str, float], ...] = ()
    reversed: bool = False


CONFIGURATIONS: dict[str, Configuration] = {
    "perpendicular-plane": Configuration(Plane),
    "halogen-plane": Configuration(Plane),
    "spinning-spot-plane": Configuration(Plane),
    "single-cone": Configuration(Cone),
    "dual-cone": Configuration(Cone, (2, 2)),
    "coaxial-cone": Configuration(Cone, fixed=(("baseline", 0.0), ("aim", 0.0), ("clock", 0.0))),
    "asymmetric-cone": Configuration(Cone, fixed=(("aim", 0.0),)),
    "reversed-cone": Configuration(Cone, fixed=(("baseline", 0.0), ("aim", 0.0), ("clock", 0.0)), reversed=True),
    "side-facing": Configuration(Sheet, side_facing=True),
    "rotating-spot": Configuration(Sheet, side_facing=True),
    "spot-array": Configuration(Beam, (1, None)),
}
"""Swanbom 2007: chapters 3, 4, 5, and figures 2.2 to 2.7 of its literature review."""

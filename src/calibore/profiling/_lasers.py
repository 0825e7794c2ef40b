"""Which laser's line is looked for in which take, where in the image, and in which colour."""

from collections.abc import Sequence
from dataclasses import dataclass

from calibore.errors import InputError
from calibore.profiling._search import Search, search_region
from calibore.rigs import Rig


@dataclass(frozen=True)
class Look:
    """Where and in which `channel` the line of the rig's `laser` is looked for."""

    laser: int
    search: Search
    channel: str


def looks_of(
    rig: Rig, nominal_radius: float, *, inner: float, outer: float, channels: Sequence[str]
) -> tuple[Look, ...]:
    """One per laser; raises InputError where its line would be out of sight."""
    regions = (search_region(rig, nominal_radius, inner=inner, outer=outer, laser=n) for n in range(len(rig.lasers)))
    return tuple(Look(n, region, channels[n]) for n, region in enumerate(regions))


def alone_in(take: int, rig: Rig, looks: Sequence[Look]) -> list[Look]:
    """The looks whose laser is lit in `take` while no other one of the same colour is."""
    lit = [look for look in looks if rig.lasers[look.laser].is_lit(take)]
    colours = [look.channel for look in lit]
    return [look for look in lit if colours.count(look.channel) == 1]


def check_told_apart(rig: Rig, looks: Sequence[Look]) -> None:
    """Raise InputError where the line of a laser could never be told from another's."""
    for look in looks:
        own = rig.lasers[look.laser].takes
        rivals = [rig.lasers[one.laser].takes for one in looks if one != look and one.channel == look.channel]
        if own is None:
            alone = None not in rivals
        else:
            alone = any(all(other is not None and take not in other for other in rivals) for take in own)
        if not alone:
            raise InputError(
                f"Laser {look.laser + 1} of {len(looks)} is never lit alone, and two lines of one colour in a picture "
                "cannot be told apart. Set laser.takes in the rig file to the takes in which each laser is lit, "
                "e.g. takes = [1]."
            )

"""Whether positions along the pipe of one of two profiles are in wrong units: decided by what then fits."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from calibore.errors import InputError
from calibore.registration import Registration, register
from calibore.scans import Profile

FACTORS = {
    25.4: "inches read as millimetres",
    10.0: "centimetres read as millimetres",
    1000.0: "metres read as millimetres",
    100.0: "metres read as centimetres",
    1 / 0.3048: "feet read as metres",
    304.8: "feet read as millimetres",
    12.0: "feet read as inches",
    2.54: "inches read as centimetres",
    1 / 0.0254: "inches read as metres",
}
ALIKE = 3.0
"""Ratio of the lengths that two scans cover, once units are right: others are not tried."""
TRIED = 3
"""Factors that are, those first that make the lengths most alike."""
RINGS = 8
"""Rings of the moving profile that are registered."""
BEYOND = 5.0
"""Standard deviations of noise that no difference of chance exceeds."""
MANY, NOISE = 0.15, 1.5
"""Share of points beyond that, once units are right, at most: the wall may have changed; how many times their noise
most of the others then differ at most."""
BETTER, FEWER = 0.5, 0.03
"""Of the share of points beyond as things stand: what may be left of it; by how much it must be less."""
SAME = 0.02
"""Of the length of the reference: guesses that differ by less in where the moving profile lies are one."""
MOST = 0.5
"""Of the points must then have a counterpart."""
KNOWN = 0.05
"""Of the length in common: a place along the pipe that is known no better tells nothing of its scale."""


@dataclass(frozen=True, eq=False)
class _Guess:
    """The two profiles with positions along the pipe of one of them multiplied or divided by `factor`."""

    factor: float
    moving: Profile
    reference: Profile


def wrong_axial_units(
    moving: Profile, reference: Profile, names: tuple[str, str], *, beyond: float = 1.0
) -> InputError | None:
    """The sentence for two profiles that fit at noise level once positions along the pipe of one are changed by a
    factor of units, and not as they stand: `beyond` is the share of points that then differ by more than chance. None
    where that is not so, as with different lengths, partial overlap or other pipes.
    """
    fitting: list[tuple[float, float]] = []
    for guess in _guesses(moving, reference):
        try:
            found = register(thinned(guess.moving), guess.reference)
        except InputError:
            continue
        if _proven(found, guess, beyond):
            fitting.append((found.scatter, guess.factor))
    return _sentence(moving, reference, names, min(fitting)[1]) if fitting else None


def thinned(profile: Profile, rings: int = RINGS) -> Profile:
    """Some of its rings, evenly along it."""
    rows = np.unique(np.linspace(0, profile.axial.size - 1, min(profile.axial.size, rings)).round().astype(int))
    return profile.rings(rows)


def _guesses(moving: Profile, reference: Profile) -> Iterator[_Guess]:
    """Likeliest first; positions are scaled about zero, or about the first station where an origin was right."""
    if min(_length(moving), _length(reference)) <= 0:
        return
    ratio = float(np.log(_length(moving) / _length(reference)))
    ways = [(abs(ratio - way * np.log(factor)), factor, way) for factor in FACTORS for way in (1, -1)]
    for unlike, factor, way in sorted(ways)[:TRIED]:
        if unlike > min(np.log(ALIKE), abs(ratio)):
            return
        places: list[float] = []
        for one, other in _scaled(moving, reference, float(factor**way)):
            place = float(np.nanmedian(one.axial_position) - np.nanmedian(other.axial_position)) / _length(other)
            new = all(abs(place - before) > SAME for before in places)
            if new and _shared(one, other) > MOST * min(_length(one), _length(other)):
                places.append(place)
                yield _Guess(factor, one, other)


def _scaled(moving: Profile, reference: Profile, scale: float) -> Iterator[tuple[Profile, Profile]]:
    """The first divided, or the second multiplied."""
    for about in (None, 0):
        yield _rescaled(moving, 1 / scale, about), reference
        yield moving, _rescaled(reference, scale, about)


def _rescaled(profile: Profile, scale: float, about: int | None) -> Profile:
    """Stations are multiplied, not what the rig sees ahead of them."""
    fixed = 0.0 if about is None else profile.axial[about]
    axial = fixed + scale * (profile.axial - fixed)
    return replace(profile, axial=axial, axial_position=profile.axial_position + (axial - profile.axial)[:, None])


def _length(profile: Profile) -> float:
    return float(np.ptp(profile.axial))


def _shared(one: Profile, other: Profile) -> float:
    """Length [m] that both cover."""
    ends = [(np.nanmin(p.axial_position), np.nanmax(p.axial_position)) for p in (one, other)]
    return float(min(ends[0][1], ends[1][1]) - max(ends[0][0], ends[1][0]))


def _proven(found: Registration, guess: _Guess, beyond: float) -> bool:
    gaps = found.gaps
    left = gaps.residual + gaps.modes.T @ found.modes if len(found.modes) else gaps.residual
    used = np.isfinite(left)
    off = float(np.mean(np.abs(left[used]) > BEYOND * np.sqrt(gaps.total[used])))
    told = "axial" not in found.untold and found.u("axial") < KNOWN * _shared(guess.moving, guess.reference)
    return told and used.mean() > MOST and found.scatter < NOISE and off < min(MANY, BETTER * beyond, beyond - FEWER)


def _sentence(moving: Profile, reference: Profile, names: tuple[str, str], factor: float) -> InputError:
    covered = [
        f"{name} covers {1e3 * np.ptp(one.axial):.4g} mm" for name, one in zip(names, (moving, reference), strict=True)
    ]
    return InputError(
        f"Positions along the pipe differ by a factor of {factor:.4g}: {covered[0]}, {covered[1]}, and only with those "
        f"of one changed by it do they fit within their noise; probably wrong units ({FACTORS[factor]}). Check the "
        "units of motion.axial in either scan.toml, or in the table that it names."
    )

"""Stops that contradict the others: a caliper misread, a gauge taken for another."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from calibore.calibration._rig_fit import RigFit
from calibore.calibration._rig_model import ERROR
from calibore.errors import InputError

FALSE_ALARM = 0.01
"""Chance that a calibration without any wrong stop loses one."""
MOST_WRONG = 0.25
"""Fraction of the stops that may be wrong; beyond it nobody can tell which are."""
LEAST_SHARED = 1e-9
"""m: stops that scatter by less agree."""


class Suspect(NamedTuple):
    """A stop whose reference is `off` [m] by what the others say, in t units of what stops scatter by, and how likely
    a good stop is to be as far off by `chance`.
    """

    stop: str
    off: float
    t: float
    chance: float


def suspects(found: RigFit) -> list[Suspect]:
    """All stops, the most suspect first; none where stops agree.

    With the error e of a stop as a parameter of prior N(0, u^2), its posterior mean m and variance V say what the other
    stops alone think of it: m / V times s^2, 1 / s^2 = 1 / V - 1 / u^2, with the variance s^2 + u^2.
    """
    from scipy import special

    explicit, freedom = (found, np.inf) if found.model.stated else _explicit(found)
    result: list[Suspect] = []
    if explicit is None:
        return result
    for stop in explicit.model.uncertain_stops:
        change, u_after = explicit.change(f"{stop}.{ERROR}")
        u = explicit.model.stops[stop].u or 0.0
        told = 1 / u_after**2 - 1 / u**2
        if told <= 0:
            continue
        off = change / u_after**2 / told
        t = off / np.sqrt(1 / told + u**2)
        t = _studentised(t, freedom)
        chance = float(2 * special.stdtr(min(freedom, 1e9) - (freedom < np.inf), -abs(t)))
        result.append(Suspect(stop, float(off), float(t), chance))
    return sorted(result, key=lambda one: one.chance)


def without_wrong_stops(found: RigFit, *, fewest: int) -> tuple[RigFit, list[Suspect]]:
    """The fit without stops that contradict the others, and those, the worst first. Raises InputError where too many
    would have to go, or fewer than `fewest` would be left.
    """
    wrong: list[Suspect] = []
    stops = len(found.model.stops)
    while True:
        listed = suspects(found)
        if not listed or listed[0].chance * len(listed) >= FALSE_ALARM:
            return found, wrong
        wrong.append(listed[0])
        if len(wrong) > max(1, MOST_WRONG * stops) or stops - len(wrong) < fewest:
            named = ", ".join(f"{one.stop} ({1e3 * one.off:+.3g} mm)" for one in wrong)
            raise InputError(
                f"The stops contradict each other: {named} fit neither the others nor the rig, and no stop can be told "
                "wrong with so few left; check the readings, then photograph more stops."
            )
        found = found.with_looks(look for look in found.model.looks if look.of_stop != listed[0].stop)


def _explicit(found: RigFit) -> tuple[RigFit | None, float]:
    """The fit with the errors of its stops as parameters, as uncertain as the stops were found to scatter; and the
    degrees of freedom of that scatter.
    """
    scatter = found.fit.group_sigma
    if scatter < LEAST_SHARED:
        return None, np.inf
    looks = [replace(look, reference=look.reference.stating(scatter)) for look in found.model.looks]
    return found.with_looks(looks), max(found.fit.degrees_of_freedom, 1.0)


def _studentised(t: float, freedom: float) -> float:
    """`t` of a scatter that holds the suspect itself, as if it had been found without it."""
    if not np.isfinite(freedom):
        return t
    left = freedom - t**2
    return float(np.sign(t) * np.inf) if left <= 0 else t * np.sqrt(max(freedom - 1, 0.5) / left)

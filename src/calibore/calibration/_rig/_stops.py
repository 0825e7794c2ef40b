"""Stops that contradict the others: a caliper misread, a gauge taken for another."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._fit import RigFit
from calibore.calibration._rig._start import prior_of
from calibore.errors import InputError

Array = NDArray[np.float64]
FALSE_ALARM = 0.01
"""Chance that a calibration without any wrong stop loses one."""
MOST_WRONG = 0.15
"""Fraction of the stops that may be wrong; beyond it nobody can tell which are."""
KEPT = 0.5
"""A stop of whose marks a robust fit keeps a smaller fraction is wrong as a whole, not some of its marks."""
FEWEST_FREEDOM = 3.0
"""Degrees of freedom of a scatter that tells a wrong stop, or may stand for a statement that the stops contradict."""
LEAST_LEFT = 0.1
"""Of the degrees of freedom of a scatter, that the stops without the suspect have at least."""
LEAST_SHARED = 1e-9
"""m: stops that scatter by less agree."""


class Suspect(NamedTuple):
    """A stop whose reference is `off` [m] by what the others say, `t` times what that scatters by; a good stop is as
    far off by `chance` only.
    """

    stop: str
    off: float
    t: float
    chance: float


def suspects(found: RigFit) -> list[Suspect]:
    """All stops, the most suspect first; none where stops do not scatter, or too few tell by how much they do.

    With the error e of a stop as a parameter of prior N(0, u^2), its posterior mean m and variance V tell what the
    marks and all other stops say of it: m / V times s^2, 1 / s^2 = 1 / V - 1 / u^2, of variance s^2 + u^2. Where u is
    what stops scatter by, it has as many degrees of freedom as errors of stops are told: the sum of 1 - V / u^2.
    """
    from scipy import special

    stated = found.model.stated
    sizes = [(reference.u or 0.0) if stated else found.stop_scatter for reference in found.model.stops.values()]
    u = np.array(sizes)
    result: list[Suspect] = []
    if (u < LEAST_SHARED).any():
        return result
    error, variance = _errors_of_stops(_with_own_scatter(found), u)
    if not stated and np.sum(1 - variance / u**2) < FEWEST_FREEDOM:
        return result
    told = 1 / variance - 1 / u**2
    freedom = np.inf if stated else max(float(np.sum(1 - variance / u**2)), 1.0)
    for number, stop in enumerate(found.model.stops):
        if told[number] > 0:
            off = error[number] / variance[number] / told[number]
            t = _studentised(float(off / np.sqrt(1 / told[number] + u[number] ** 2)), freedom)
            chance = special.erfc(abs(t) / np.sqrt(2)) if stated else 2 * special.stdtr(max(freedom - 1, 1.0), -abs(t))
            result.append(Suspect(stop, float(off), t, float(chance)))
    return sorted(result, key=lambda one: one.chance)


def without_wrong_stops(found: RigFit, *, fewest: int) -> tuple[RigFit, list[Suspect]]:
    """The fit without stops that contradict the others, and those, the worst first; where all scatter by more than was
    stated, with the scatter found. Raises InputError where too many would have to go, or fewer than `fewest` be left.
    """
    wrong: list[Suspect] = []
    first, stops = found, len(found.model.stops)
    while True:
        listed = suspects(found)
        if not listed or listed[0].chance * len(listed) >= FALSE_ALARM:
            return found, wrong
        wrong.append(listed[0])
        if len(wrong) > max(1, MOST_WRONG * stops) or stops - len(wrong) < fewest:
            scattering = _with_own_scatter(first)
            if scattering is first or scattering.fit.degrees_of_freedom < FEWEST_FREEDOM:
                raise InputError(_contradiction(found, wrong))
            return without_wrong_stops(scattering, fewest=fewest)
        found = found.with_looks(look for look in found.model.looks if look.of_stop != listed[0].stop)


def _contradiction(found: RigFit, wrong: list[Suspect]) -> str:
    named = ", ".join(f"{one.stop} ({1e3 * one.off:+.3g} mm)" for one in wrong)
    what = "their stated uncertainty is too small, or the lens law is not the camera's" if found.model.stated else ""
    return (
        f"The stops contradict each other: {named} fit neither the others nor the rig, and nobody can tell which are "
        f"wrong; check the readings{f', whether {what}' if what else ''}, then photograph more stops."
    )


def _with_own_scatter(found: RigFit) -> RigFit:
    """The same fit with the scatter that stops show by themselves: what was stated too small would pass for noise of
    the marks, and hide what it is.
    """
    if not found.model.stated:
        return found
    looks = [replace(look, reference=look.reference.stating(None)) for look in found.model.looks]
    try:
        return found.with_looks(looks)
    except InputError:  # too few stops to see how they scatter
        return found


def _errors_of_stops(found: RigFit, u: Array) -> tuple[Array, Array]:
    """Posterior means (g,) [m] and variances of the errors of all stops, of standard deviations `u` (g,) before."""
    fit, model = found.fit, found.model
    weight = _counting(found) / (fit.sigma * np.sqrt(_shared_by_neighbours(fit.partial_autocorrelation)))
    errors = np.zeros((weight.size, u.size))
    errors[np.arange(weight.size), model.stop_of] = u[model.stop_of] / found.slope
    scale = np.where(np.isfinite(fit.u) & (fit.u > 0), fit.u, 1.0)
    rows = weight[:, None] * np.concatenate([fit.jacobian * scale, errors], axis=1)
    aims = weight * fit.residuals
    known = prior_of(model, found.prior)
    before = np.zeros((0, rows.shape[1]))
    aside = np.zeros(0)
    if known is not None:
        root = np.linalg.inv(np.linalg.cholesky(known.matrix))
        index = [fit.names.index(name) for name in known.names]
        before = np.zeros((len(index), rows.shape[1]))
        before[:, index] = root * scale[index]
        aside = root @ (known.mean - fit.values[index])
    own = np.concatenate([np.zeros((u.size, scale.size)), np.eye(u.size)], axis=1)
    q, r = np.linalg.qr(np.concatenate([rows, before, own]))
    inverse = np.linalg.pinv(r)
    step = inverse @ (q.T @ np.concatenate([aims, aside, np.zeros(u.size)]))
    variance = np.sum(inverse**2, axis=1)
    return step[scale.size :] * u, variance[scale.size :] * u**2


def _counting(found: RigFit) -> Array:
    """Weights (n,) of the marks; all of a stop count that a robust fit has left out as a whole, to see its error."""
    stop, weights = found.model.stop_of, found.fit.weights
    kept = np.bincount(stop, weights) / np.bincount(stop)
    return np.where(kept[stop] < KEPT, 1.0, weights)


def _shared_by_neighbours(partial: Array) -> float:
    """How many times as uncertain, in variance, means along a chain are as those of independent marks: the sum of all
    autocorrelations, of the autoregression with the `partial` ones (q,).
    """
    weights = np.zeros(0)
    for one in partial:
        weights = np.append(weights - one * weights[::-1], one)
    return float(np.prod(1 - partial**2) / (1 - weights.sum()) ** 2)


def _studentised(t: float, freedom: float) -> float:
    """`t` of a scatter that holds the suspect itself, as if it had been found without it. `freedom` is an estimate:
    that nothing at all is left for the others to scatter by is never certain.
    """
    if not np.isfinite(freedom):
        return t
    left = max(freedom - t**2, LEAST_LEFT * freedom)
    return t * float(np.sqrt(max(freedom - 1, 0.5) / left))

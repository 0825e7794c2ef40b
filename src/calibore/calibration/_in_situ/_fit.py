"""The rig that fits the reference in the pipe: which parameters are looked for, which change alone explains it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Comparison
from calibore.calibration._in_situ._change import Change, change_of
from calibore.calibration._in_words import word_of
from calibore.calibration._rig._fit import RigFit, fit_rig, foreseen
from calibore.calibration._rig._looks import Look
from calibore.errors import InputError
from calibore.fitting import information_criteria
from calibore.rigs import Rig, SideFacing, value_of, values_of
from calibore.uncertainty import Covariance, Quantity

Array = NDArray[np.float64]

TOLD = 0.1
"""Lengths and k are told where their foreseen standard uncertainty is below this fraction of them."""
TOLD_ANGLE = np.radians(3.0)
TOLD_SLOPE = 0.03
CLEARLY = 4.0
"""Difference of AICc from which on one model is clearly better."""
LENGTHS = ("baseline", "k", "offset")
ANGLES = ("aim", "half_angle")


@dataclass(frozen=True, eq=False)
class InSitu:
    """`found` from the reference alone and, where asked for, `combined` with the calibration in use; the `change` of
    the parameters looked for; the models tried, the best first; parameters that the reference could not tell, `untold`.
    """

    found: RigFit
    combined: RigFit | None
    change: Change
    models: tuple[Comparison, ...]
    untold: tuple[str, ...]

    @property
    def result(self) -> RigFit:
        return self.combined or self.found


def fit_in_situ(
    rig: Rig, looks: tuple[Look, ...], *, free: tuple[str, ...] | None = None, prior: bool = False
) -> InSitu:
    """`free`: parameters to look for; None: those that may have changed and that the reference tells. `prior`: let the
    calibration in use, `rig.covariance`, count beside the reference.
    """
    old = rig.covariance or Covariance.independent({})
    _check(rig, free)
    possible = free or candidates(rig)
    wanted = possible if free else _told(rig, looks, possible, old)
    found = _fit(rig, looks, wanted, old)
    clean = _without_outliers(found)
    models = _models(rig, clean, wanted, possible, old)
    if len(wanted) < len(possible) and (better := _better_alone(models, wanted)):
        wanted = (better,)
        found = _fit(rig, looks, wanted, old)
    combined = None
    if prior:
        every = (*wanted, *_beside(old, wanted))
        combined = fit_rig(
            rig, clean, free=every, prior=old.restricted([n for n in every if n in old.names]), robust=False
        )
    untold = tuple(name for name in possible if name not in wanted)
    return InSitu(found, combined, change_of(found, wanted, old=old), models, untold)


def _beside(old: Covariance, wanted: tuple[str, ...]) -> tuple[str, ...]:
    """Parameters that are not looked for but known with an uncertainty."""
    return tuple(name for name, u in zip(old.names, old.u, strict=True) if u > 0 and name not in wanted)


def _fit(rig: Rig, looks: tuple[Look, ...], wanted: tuple[str, ...], old: Covariance, *, robust: bool = True) -> RigFit:
    beside = _beside(old, wanted)
    return fit_rig(rig, looks, free=(*wanted, *beside), prior=old.restricted(beside) if beside else None, robust=robust)


def _better_alone(models: tuple[Comparison, ...], wanted: tuple[str, ...]) -> str | None:
    """The parameter whose change alone explains the pipe clearly better than that of the one which was looked for."""
    alone = {next(iter(model.estimates)): model.aicc for model in models if len(model.estimates) == 1}
    best = min(alone, key=lambda name: alone[name], default=None)
    if len(wanted) > 1 or best is None or best in wanted:
        return None
    first = min(alone.get(name, np.inf) for name in wanted)
    return best if alone[best] < first - CLEARLY else None


def candidates(rig: Rig) -> tuple[str, ...]:
    """What may have changed since the calibration, the likeliest first (Swanbom 2007, 8.3.3.1 and 8.3.3.2).

    With a plane across the camera's axis the baseline only scales everything, and lenses are locked by set screws; on a
    side-facing head zoom, baseline and aim may all have moved.
    """
    tables = [rig.laser_table(number) for number in range(len(rig.lasers))]
    if isinstance(rig.mount, SideFacing):
        return ("camera.k", "laser.baseline", "laser.aim")
    names = [f"{table}.{key}" for key in ("baseline", "aim", "half_angle") for table in tables]
    surface = [name for name in names if name in rig.parameter_names]
    if any(name.endswith(".aim") for name in surface):
        surface.insert(len(tables), "camera.k")
    return tuple(surface) or ("camera.k",)


def _check(rig: Rig, free: tuple[str, ...] | None) -> None:
    unknown = set(free or ()) - set(rig.parameter_names)
    if unknown:
        raise InputError(
            f"free names {', '.join(sorted(unknown))}, which this rig has not; allowed: "
            f"{', '.join(rig.parameter_names)}."
        )
    if free == ():
        raise InputError('free is empty; name parameters such as "laser.baseline", or leave it out.')


def _told(rig: Rig, looks: tuple[Look, ...], possible: tuple[str, ...], old: Covariance) -> tuple[str, ...]:
    """Those of the `possible` parameters that the reference tells apart, given up from the last."""
    left = possible
    while True:
        beside = _beside(old, left)
        u = foreseen(rig, looks, free=(*left, *beside), prior=old.restricted(beside) if beside else None)
        if all(u[name] <= _enough(rig, name) for name in left):
            return left
        if len(left) == 1:
            raise InputError(
                f"The reference does not tell {word_of(left[0])}: the marks that can be compared with it are too few "
                "or too alike; scan a stretch of pipe with more clock positions and stations."
            )
        left = left[:-1]


def _enough(rig: Rig, name: str) -> float:
    key = name.split(".")[-1]
    return TOLD * abs(value_of(rig, name)) if key in LENGTHS else TOLD_ANGLE if key in ANGLES else TOLD_SLOPE


def _without_outliers(found: RigFit) -> tuple[Look, ...]:
    """The looks with the marks that the fit kept."""
    looks = []
    for number, look in enumerate(found.model.looks):
        kept = found.fit.weights[found.model.look_of == number] > 0
        if kept.any():
            marks = {name: getattr(look, name)[kept] for name in ("u", "v", "direction", "sigma")}
            looks.append(replace(look, **marks))
    return tuple(looks)


def _models(
    rig: Rig, looks: tuple[Look, ...], wanted: tuple[str, ...], possible: tuple[str, ...], old: Covariance
) -> tuple[Comparison, ...]:
    """Nothing moved, one parameter moved, all of them: the same marks for all, the best first."""
    fits, rows = [], []
    for moving in dict.fromkeys([(), *((name,) for name in possible), wanted]):
        try:
            fit = _fit(rig, looks, moving, _held(old, possible), robust=False)
        except InputError:
            continue
        fits.append((moving, fit))
        rows.append(information_criteria(fit.fit))
    criteria = np.array(rows) - np.min(rows, axis=0) if rows else np.zeros((0, 2))
    order = np.argsort(criteria[:, 0], kind="stable")
    return tuple(_comparison(*fits[i], *criteria[i]) for i in order)


def _held(old: Covariance, possible: tuple[str, ...]) -> Covariance:
    """What is known of the parameters that cannot have moved; the others are either free or held."""
    return old.restricted([name for name in old.names if name not in possible])


def _comparison(moving: tuple[str, ...], found: RigFit, aicc: float, bic: float) -> Comparison:
    values, freedom = values_of(found.rig, moving), found.fit.degrees_of_freedom
    u = dict(zip(moving, found.covariance.restricted(moving).u.tolist(), strict=True)) if moving else {}
    estimates = {name: Quantity(value, u[name], freedom) for name, value in values.items()}
    rmse = float(np.sqrt(np.mean(found.fit.residuals**2)))
    model = " and ".join(map(word_of, moving)) + " moved" if moving else "nothing moved"
    return Comparison(model, len(found.fit.names), rmse, float(aicc), float(bic), float("nan"), estimates)

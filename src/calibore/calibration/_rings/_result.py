"""What a fit of ring photographs means: the rig, how well it is known, and the evidence."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Comparison, Observations
from calibore.calibration._evidence import of_fit
from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.calibration._rings._choice import BASELINE, DETERMINED, SCALE, Trial
from calibore.calibration._rings._fit import RingFit
from calibore.calibration._rings._model import PLANE
from calibore.calibration._rings._sight import Sight
from calibore.lasers import Plane
from calibore.optics import LENS_LAWS
from calibore.rigs import Rig, ValidRegion
from calibore.uncertainty import Covariance, Quantity

Array = NDArray[np.float64]

RULED_OUT = 0.01
"""Akaike weight below which a lens law is ruled out."""
ONLY_RATIO = "tells D / k only: its D and k are the nominal baseline's, not the pictures'"
UNDETERMINED = "leaves D and k open (u {:.0%})"


@dataclass(frozen=True, eq=False)
class Outcome:
    """The `ring_fit` of the recommended lens, all `trials`, the marks of `sight`; `covariance` of what is calibrated,
    `rivals` the weight of each other lens as simple that the marks do not rule out.
    """

    ring_fit: RingFit
    chosen: Trial
    trials: list[Trial]
    sight: Sight
    covariance: Covariance
    rivals: dict[str, float]

    def value(self, name: str) -> Quantity:
        u = self.covariance.u[self.covariance.names.index(name)]
        return Quantity(self.ring_fit.fit.value(name), float(u), self.ring_fit.fit.degrees_of_freedom)

    @property
    def across(self) -> Rig:
        """The rig whose light stands at the target's distance in the first picture, straight across the camera's axis:
        how the target was held says nothing of the light.
        """
        rig, fit = self.rig, self.ring_fit.fit
        light = replace(rig.lasers[0], surface=Plane(fit.value(BASELINE)))
        known = self.covariance.restricted([name for name in self.covariance.names if name not in PLANE[1:]])
        return replace(rig, lasers=(light,), covariance=known)

    @property
    def rig(self) -> Rig:
        """The same, its light tilted as the target was."""
        fit = self.ring_fit.fit
        return self.ring_fit.model.rig(fit.values, 0).knowing(self.covariance, fit.degrees_of_freedom)


def outcome_of(ring_fit: RingFit, chosen: Trial, trials: list[Trial], sight: Sight) -> Outcome:
    """Covariance of the calibrated parameters, with the doubt about the lens law: an equally simple law that the marks
    do not rule out counts with its Akaike weight and its difference from the recommended one (Burnham and Anderson
    2002, eq. 4.9, as a matrix).
    """
    names = calibrated(ring_fit)
    index = [ring_fit.fit.names.index(name) for name in names]
    matrix = ring_fit.fit.covariance[np.ix_(index, index)].copy()
    weights = _weights(chosen, trials)
    for trial, weight in weights.items():
        aside = _difference(trial.ring_fit, ring_fit, names)
        matrix += weight * np.outer(aside, aside)
    rivals = {trial.lens.name: weight for trial, weight in weights.items()}
    return Outcome(ring_fit, chosen, trials, sight, Covariance(names, matrix), rivals)


def calibrated(ring_fit: RingFit) -> list[str]:
    """The names of what is calibrated, laser first."""
    model = ring_fit.model
    return [*PLANE, *(name for name in (*model.lens.parameters, ASPECT, *CENTRE) if name in model.names)]


def _weights(chosen: Trial, trials: list[Trial]) -> dict[Trial, float]:
    """Akaike weights of the other lenses of one parameter."""
    if chosen.lens.extras:
        return {}
    simple = [trial for trial in trials if not trial.lens.extras]
    least = min(trial.aicc for trial in simple)
    likelihood = {trial: float(np.exp((least - trial.aicc) / 2)) for trial in simple}
    total = sum(likelihood.values())
    return {trial: w / total for trial, w in likelihood.items() if trial is not chosen and w > RULED_OUT * total}


def _difference(other: RingFit, chosen: RingFit, names: Sequence[str]) -> Array:
    """By how much another law would have the parameters differ; its k as the chosen law's of the same scale in the
    middle of the picture.
    """
    slopes = [float(LENS_LAWS[fit.lens.law].slope(np.zeros(1))[0]) for fit in (other, chosen)]
    factor = {SCALE: slopes[0] / slopes[1]}
    return np.array([other.fit.value(name) * factor.get(name, 1.0) - chosen.fit.value(name) for name in names])


def comparisons(outcome: Outcome, lenses: Sequence[LensModel]) -> tuple[Comparison, ...]:
    """The table of lenses (Swanbom 2007, table 6.1), those too that cannot be fitted."""
    found = {trial.lens: trial for trial in outcome.trials}
    return tuple(
        _row(found[lens], outcome.chosen, outcome.trials) if lens in found else _no_row(lens) for lens in lenses
    )


def _no_row(lens: LensModel) -> Comparison:
    nan = float("nan")
    return Comparison(lens.name, len(lens.parameters), nan, nan, nan, nan, remark="cannot be fitted to these marks")


def _row(trial: Trial, chosen: Trial, trials: list[Trial]) -> Comparison:
    ring_fit = trial.ring_fit
    names = [BASELINE, *ring_fit.lens.parameters]
    freedom = max(ring_fit.fit.degrees_of_freedom, 1.0)
    return Comparison(
        model=trial.lens.name,
        parameters=len(ring_fit.lens.parameters),
        rmse=ring_fit.rms,
        aicc=trial.aicc - min(one.aicc for one in trials),
        bic=trial.bic - min(one.bic for one in trials),
        cross_validated=trial.rms,
        estimates={name: Quantity(ring_fit.fit.value(name), ring_fit.u(name), freedom) for name in names},
        remark=_remark(trial, chosen),
    )


def _remark(trial: Trial, chosen: Trial) -> str:
    remarks = ["recommended"] if trial is chosen else []
    if trial.lens.law == "perspective" and not trial.lens.extras:
        remarks.append(ONLY_RATIO)
    elif trial.relative_u > DETERMINED:
        remarks.append(UNDETERMINED.format(trial.relative_u))
    return "; ".join(remarks)


def valid_region(outcome: Outcome) -> ValidRegion:
    """From the axis, about which every lens is symmetric, to the farthest marks of the first picture's plane."""
    model, values = outcome.ring_fit.model, outcome.ring_fit.fit.values
    zenith, radius = [], []
    for number, marks in enumerate(model.marks):
        rays = model.camera(values).unproject(marks.u, marks.v)
        zenith.append(np.arccos(np.clip(rays.direction[:, 2], -1, 1)).max())
        if number == 0:
            plane = model.target(values, 0).plane
            points = plane.meet(*rays).distance[0][:, None] * rays.direction
            radius.append(np.hypot(points[:, 0], points[:, 1]).max())
    return ValidRegion((0.0, float(max(zenith))), (0.0, float(max(radius))))


def observations_of(outcome: Outcome, files: Sequence[int]) -> Observations:
    """One row per stretch of a line; `files`: the number of each picture's file."""
    fit, marks = outcome.ring_fit.fit, outcome.ring_fit.model.marks
    return Observations(
        file=np.array(files, dtype=np.intp)[outcome.sight.picture],
        u=np.concatenate([one.u for one in marks]),
        v=np.concatenate([one.v for one in marks]),
        whitened=_with_doubt(outcome) if outcome.rivals else None,
        **of_fit(fit),
    )


def _with_doubt(outcome: Outcome) -> Array:
    """The root of the information on all parameters that is left when the doubt about the law is counted: residuals of
    one law cannot tell it.
    """
    fit, names = outcome.ring_fit.fit, outcome.covariance.names
    index = np.ix_(*[[fit.names.index(name) for name in names]] * 2)
    total = fit.covariance.copy()
    total[index] = outcome.covariance.matrix
    u = np.sqrt(np.diag(total))
    return np.linalg.inv(np.linalg.cholesky(total / np.outer(u, u))) / u

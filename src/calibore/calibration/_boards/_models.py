"""All lens models on the same marks: how well each fits, predicts boards it has not seen, and which one to take."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate, bundle, shared_covariance
from calibore.calibration._boards._data import BoardData
from calibore.calibration._boards._start import started_like
from calibore.calibration._calibration import Comparison
from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel, lens_models
from calibore.errors import InputError
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]

HIGHEST = LensModel("polynomial", tuple(f"polynomial_{power}" for power in (3, 5, 7, 9)))
"""Boards carry more marks than rings: they can tell one more power."""
DOUBT = "check corners and square, and that one flat board was photographed with one camera at one setting"
FOLDS = 6
WORSE = 1.0  # standard errors of the difference in squared error of boards left out
STRONG = 6.0  # difference in BIC beyond which a model has strong evidence against it (Kass and Raftery 1995)
HALF, TWICE = 0.5, 2.0
FOLLOWED = 4  # steps of a fit without some boards, from the fit to all
NEAR = 1e-4  # of the sum of squares: a step that takes less changes no prediction that matters


def board_models(law: str | None) -> tuple[LensModel, ...]:
    models = lens_models(law)
    return (*models, HIGHEST) if law in (None, "polynomial") else models


@dataclass(frozen=True, eq=False)
class Trial:
    """A `model` on `data`: its `estimate`, None where there is none and `why`; `left_out` (m,): mean squared error
    [px^2] of each board when camera and bends come from others.
    """

    model: LensModel
    data: BoardData
    estimate: Estimate | None
    left_out: Array
    why: str = ""

    @property
    def parameters(self) -> int:
        """Of the camera."""
        return len(self.model.parameters) + 1 + len(CENTRE)

    @property
    def rms(self) -> float:
        return self.estimate.rms if self.estimate else np.inf

    @property
    def cross_validated(self) -> float:
        return float(np.sqrt(self.left_out @ self.data.sums(np.ones(self.data.owner.size)) / self.data.owner.size))

    @cached_property
    def criteria(self) -> tuple[float, float]:
        """AICc and BIC, up to what all models share."""
        if self.estimate is None:
            return np.inf, np.inf
        scaled = self.estimate.residual / self.data.sigma[:, None]
        n, k = scaled.size, self.parameters + 6 * self.data.boards + 1
        deviance = n * np.log(np.sum(scaled**2) / n)
        return deviance + 2 * k + 2 * k * (k + 1) / max(n - k - 1, 1), deviance + k * np.log(n)


def tried_models(
    data: BoardData, models: Sequence[LensModel], starts: Sequence[Estimate], *, done: Callable[[], None]
) -> list[Trial]:
    """Each of `models`, `done` called after each. `starts` hold one estimate of each law that images the boards."""
    trials: list[Trial] = []
    known = list(starts)
    for model in models:
        try:
            estimate = _converged(data, started_like(model, _nearest(model, known)))
            trials.append(Trial(model, data, estimate, left_out_errors(data, estimate)))
            known.append(estimate)
        except InputError as error:
            trials.append(Trial(model, data, None, np.full(data.boards, np.inf), str(error)))
        done()
    return trials


def _nearest(model: LensModel, known: Sequence[Estimate]) -> Estimate:
    own = [estimate for estimate in known if estimate.model.law == model.law or model.law == "polynomial"]
    if not own:
        raise InputError("it does not image marks so far from the axis")
    return min(own, key=lambda estimate: estimate.rms)


def _converged(data: BoardData, start: Estimate) -> Estimate:
    estimate = bundle(data, start)
    if not estimate.converged:
        raise InputError("the fit does not converge")
    point, aspect = estimate.camera.principal_point, estimate.camera.aspect
    if not (-0.5 < point[0] < data.size[0] - 0.5 and -0.5 < point[1] < data.size[1] - 0.5):
        raise InputError(f"the fit puts the principal point outside the picture, at {point[0]:.0f}, {point[1]:.0f} px")
    if not HALF < aspect < TWICE:
        raise InputError(f"the fit puts the pixel aspect at {aspect:.3g}")
    return estimate


def left_out_errors(data: BoardData, estimate: Estimate) -> Array:
    """Mean squared error (m,) [px^2] of a coordinate of each board's marks when only its own pose is fitted to it."""
    errors = np.full(data.boards, np.inf)
    folds = np.arange(data.boards) % min(FOLDS, data.boards)
    for fold in range(folds.max() + 1):
        inside, outside = folds != fold, folds == fold
        try:
            taught = bundle(data.of_boards(inside), estimate.of_boards(inside, data), settled=NEAR, steps=FOLLOWED)
            judged = estimate.of_boards(outside, data).with_camera_of(taught)
            rest = data.of_boards(outside)
            judged = bundle(rest, judged, free=(), settled=NEAR, steps=FOLLOWED)
        except InputError:
            continue
        errors[outside] = rest.sums(judged.square) / rest.sums(np.ones(rest.owner.size))
    return errors


def recommended(trials: Sequence[Trial]) -> Trial:
    """The model of fewest parameters that neither predicts left-out boards significantly worse than the best nor has
    strong evidence against it; among equals the one that predicts best. Raises InputError where none fits.
    """
    fitted = [trial for trial in trials if trial.estimate is not None and np.isfinite(trial.left_out).all()]
    if not fitted:
        raise InputError(f"no lens model fits ({trials[0].model.name}: {trials[0].why}); {DOUBT}.")
    best = min(fitted, key=lambda trial: trial.cross_validated)
    good = [trial for trial in fitted if not why_not(trial, best, fitted)]
    return min(good or [best], key=lambda trial: (trial.parameters, trial.cross_validated))


def why_not(trial: Trial, best: Trial, fitted: Sequence[Trial]) -> str:
    """Why `trial` is significantly worse than the `best` at predicting, "" where it is not."""
    if trial.estimate is None:
        return trial.why
    if trial is best:
        return ""
    evidence = trial.criteria[1] - min(other.criteria[1] for other in fitted)
    if evidence > STRONG:
        return f"strong evidence against it: BIC {evidence:.0f} above the best"
    loss = trial.left_out - best.left_out
    error = float(np.std(loss, ddof=1) / np.sqrt(loss.size))
    return (
        f"predicts boards left out worse, by {loss.mean() / error:.1f} standard errors"
        if loss.mean() > WORSE * error
        else ""
    )


def comparison_table(trials: Sequence[Trial], chosen: Trial) -> tuple[Comparison, ...]:
    fitted = [trial for trial in trials if trial.estimate is not None]
    best = min(fitted, key=lambda trial: trial.cross_validated)
    least = np.min([trial.criteria for trial in fitted], axis=0)
    rows = []
    for trial in trials:
        aicc, bic = np.array(trial.criteria) - least
        remark = "recommended" if trial is chosen else why_not(trial, best, fitted) or "as good, more parameters"
        rows.append(
            Comparison(
                trial.model.name,
                trial.parameters,
                trial.rms,
                float(aicc),
                float(bic),
                trial.cross_validated,
                _estimates(trial),
                remark,
            )
        )
    return tuple(rows)


def _estimates(trial: Trial) -> dict[str, Quantity]:
    if trial.estimate is None:
        return {}
    u = np.sqrt(np.diag(shared_covariance(trial.data, trial.estimate)))
    pairs = zip(trial.estimate.names, trial.estimate.values, u, strict=False)
    return {name: Quantity(float(value), float(error)) for name, value, error in pairs if name != ASPECT}

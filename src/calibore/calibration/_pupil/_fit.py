"""The pupil's place from all pictures of the two pins together, for every lens law that the pictures allow."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Comparison
from calibore.calibration._pupil._model import CAMERA, OFFSET, PUPIL, SLIDE, TURN, PinModel, Sightings
from calibore.calibration._pupil._start import start_values
from calibore.errors import InputError
from calibore.fitting import Fit, information_criteria, least_squares
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]

U_POSE = {CAMERA[0]: 0.05, CAMERA[1]: 0.05, CAMERA[2]: 0.02}
"""rad; how well a camera sits on its slide before any picture tells."""
U_OFFSET = 0.5e-3
"""m; how well the lens axis was set over the pivot."""
U_LEAN = 0.01
"""rad; how upright a pin is."""
TENABLE = 10.0
"""A law whose AICc exceeds the best by more has no support left."""


@dataclass(frozen=True, eq=False)
class PupilFit:
    """The fit of the best law, `model` with the senses of the scales; the pupil's slide reading `pupil` with its
    uncertainty, doubt about the law included; all laws in `comparisons`, the best first. `seen` counts turns to the
    right.
    """

    fit: Fit
    model: PinModel
    seen: Sightings
    pupil: Quantity
    comparisons: tuple[Comparison, ...]


def fit_pupil(
    seen: Sightings, *, slides: Array, size: tuple[int, int], laws: tuple[str, ...], u_slide: float, u_turntable: float
) -> PupilFit:
    """Raises InputError where the pictures cannot tell, or nothing converges."""
    pictures = np.unique(seen.picture)
    model = PinModel(laws[0], *size, slides, pictures)
    start = start_values(model, seen)
    seen = replace(seen, turn=start.rightwards * seen.turn)
    found: list[tuple[PinModel, Fit]] = []
    failure: InputError | None = None
    for law in laws:
        model = PinModel(law, *size, slides, pictures, start.forwards)
        values = np.array(start.values)
        values[1] *= 2.0 if law in ("stereographic", "equisolid-angle") else 1.0
        try:
            found.append((model, _fit(model, seen, values, u_slide=u_slide, u_turntable=u_turntable)))
        except InputError as error:
            failure = error
    if not found:
        raise InputError(f"Pins and pictures do not fit together: {failure}") from failure
    return _chosen(found, seen)


def _fit(model: PinModel, seen: Sightings, start: Array, *, u_slide: float, u_turntable: float) -> Fit:
    mean, u = _prior(model, u_slide=u_slide, u_turntable=u_turntable)

    def residuals(values: Array) -> tuple[Array, Array]:
        predicted, by_values = model.predicted(values, seen)
        return seen.u - predicted, by_values

    pin_in_picture = 2 * seen.picture + seen.near
    return least_squares(
        residuals,
        np.concatenate([start, np.zeros(model.pictures.size)]),
        names=model.names,
        sigma=seen.sigma,
        prior=(tuple(mean), np.array(list(mean.values())), np.diag(np.array(list(u.values())) ** 2)),
        groups=pin_in_picture,
        chains=pin_in_picture,
    )


def _prior(model: PinModel, *, u_slide: float, u_turntable: float) -> tuple[dict[str, float], dict[str, float]]:
    """What is known before any picture: values and standard uncertainties by name."""
    u = {**U_POSE, OFFSET: U_OFFSET, **{name: U_LEAN for name in model.names if "lean" in name}}
    u |= {name: u_turntable for name in model.names if name.startswith(TURN)}
    mean = dict.fromkeys(u, 0.0)
    for number, reading in enumerate(model.slides.tolist()):
        mean[f"{SLIDE}{number}"], u[f"{SLIDE}{number}"] = reading, u_slide
    return mean, u


def _chosen(found: list[tuple[PinModel, Fit]], seen: Sightings) -> PupilFit:
    """The law of least AICc; the scatter of the pupil over the laws, weighted by their support, adds to its u."""
    criteria = np.array([information_criteria(fit) for _, fit in found])
    criteria -= criteria.min(axis=0)
    order = np.argsort(criteria[:, 0], kind="stable")
    best, fit = found[order[0]]
    support = np.where(criteria[:, 0] <= TENABLE, np.exp(-criteria[:, 0] / 2), 0.0)
    off = np.array([one.value(PUPIL) for _, one in found]) - fit.value(PUPIL)
    by_law = float(support @ off**2 / support.sum())
    index = fit.names.index(PUPIL)
    pupil = Quantity(
        fit.value(PUPIL),
        float(np.hypot(fit.u[index], np.sqrt(by_law))),
        fit.degrees_of_freedom_of(np.eye(len(fit.names))[index]),
    )
    compared = tuple(_comparison(*found[i], *criteria[i]) for i in order)
    return PupilFit(fit, best, seen, pupil, compared)


def _comparison(model: PinModel, fit: Fit, aicc: float, bic: float) -> Comparison:
    kept = fit.weights > 0
    estimates = {
        name: Quantity(fit.value(name), float(fit.u[fit.names.index(name)]), fit.degrees_of_freedom)
        for name in (PUPIL, "camera.k")
    }
    rmse = float(np.sqrt(np.mean(fit.residuals[kept] ** 2)))
    remark = "" if aicc <= TENABLE else "the pictures speak against it"
    return Comparison(model.law, len(fit.names), rmse, float(aicc), float(bic), float("nan"), estimates, remark)

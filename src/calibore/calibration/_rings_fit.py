"""One lens model fitted to the marks of ring photographs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel, middle_of
from calibore.calibration._rings_model import RingModel, target_names
from calibore.calibration._rings_sight import Sight
from calibore.calibration._rings_start import start_values
from calibore.fitting import Fit, least_squares

Array = NDArray[np.float64]

U_CENTRE = 0.05
"""Of the image's width: standard uncertainty of the principal point before any picture. Lenses are screwed in front of
the middle of their sensor; a twentieth is generous, and it counts only where the target fills a narrow view."""
U_BASELINE = 0.5
"""Of the nominal baseline: it is measured to the front of the lens, the pupil lies somewhere behind."""
FARTHEST = 10.0
"""A target at more than this many nominal baselines, or at less than one such fraction, is at a bound."""
STEEPEST, ASPECTS = 1.0, (0.5, 2.0)


@dataclass(frozen=True, eq=False)
class RingFit:
    """`fit` of `model`; `of_print`: lines share errors of their print [m], rather than of their picture [px]."""

    model: RingModel
    fit: Fit
    of_print: bool = False

    @property
    def lens(self) -> LensModel:
        return self.model.lens

    def u(self, name: str) -> float:
        return float(self.fit.u[self.fit.names.index(name)])

    def correlation(self, first: str, second: str) -> float:
        i, j = self.fit.names.index(first), self.fit.names.index(second)
        return float(self.fit.covariance[i, j] / (self.fit.u[i] * self.fit.u[j]))


def fit_lens(
    sight: Sight,
    lens: LensModel,
    *,
    start: Array | None = None,
    neighbours: bool = True,
    lines: bool = True,
    robust: bool = True,
    of_print: bool = False,
) -> RingFit:
    """`lens`, pixel aspect, principal point and places of the target from all marks together.

    Errors that the marks of a line share are told by the marks: those of a line in its picture [px], or with `of_print`
    those of a printed line in all pictures [m]. Raises InputError where the fit fails or ends at a bound.
    """
    known = sight.u_ring is not None and sight.u_ring > 0
    model = RingModel(lens, sight.printed, sight.marks, sight.size, square=sight.square, printed_errors=known)
    if start is None:
        start = start_values(model, sight.nominal_baseline, principal_point=sight.principal_point)
    groups = sight.line if of_print else sight.sight_of_line
    fit = least_squares(
        model,
        start,
        names=model.names,
        sigma=sight.sigma / np.median(sight.sigma),
        prior=_prior(sight, model),
        groups=groups if lines else None,
        group_loads=model.pixels_per_metre(start) if lines and of_print else None,
        chains=sight.chains if neighbours else None,
        robust=robust,
        bounds=_bounds(sight, model),
    )
    return RingFit(model, fit, of_print)


def _prior(sight: Sight, model: RingModel) -> tuple[list[str], Array, Array]:
    """What is known before any picture: weak, but for the stated uncertainty of the printed radii."""
    width, height = sight.size
    point = sight.principal_point or middle_of(width, height)
    names, mean = [*CENTRE, "laser.baseline"], [*point, sight.nominal_baseline]
    u = [U_CENTRE * width] * 2 + [U_BASELINE * sight.nominal_baseline]
    if model.printed_errors and sight.u_ring:
        rings = list(model.names[-sight.printed.radii.size :])
        names, mean, u = names + rings, mean + [0.0] * len(rings), u + [sight.u_ring] * len(rings)
    return names, np.array(mean), np.diag(np.square(u))


def _bounds(sight: Sight, model: RingModel) -> dict[str, tuple[float, float]]:
    bounds = {} if sight.square else {ASPECT: ASPECTS}
    for number in range(len(sight.marks)):
        baseline, tilt_x, tilt_y, *_ = target_names(number)
        bounds |= {tilt_x: (-STEEPEST, STEEPEST), tilt_y: (-STEEPEST, STEEPEST)}
        if number == 0:
            bounds[baseline] = sight.nominal_baseline / FARTHEST, sight.nominal_baseline * FARTHEST
    return bounds

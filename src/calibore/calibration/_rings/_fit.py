"""One lens model fitted to the marks of ring photographs."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel, middle_of
from calibore.calibration._rings._model import FINDER, RingModel, target_names
from calibore.calibration._rings._sight import Sight, condensed, evened
from calibore.calibration._rings._start import start_values
from calibore.errors import InputError
from calibore.fitting import Fit, least_squares

Array = NDArray[np.float64]

U_CENTRE = 0.05
"""Of the image's width: standard uncertainty of the principal point before any picture. Lenses are screwed in front of
the middle of their sensor; a twentieth is generous, and it counts only where the target fills a narrow view."""
U_BASELINE = 0.5
"""Of the nominal baseline, where nothing is stated: it is measured to the front of the lens, the pupil lies behind."""
U_FINDER = 0.001
"""px: standard uncertainty of what all marks of a picture err alike, measured on rendered photographs."""
FARTHEST = 10.0
"""A target at more than this many nominal baselines, or at less than one such fraction, is at a bound."""
CLOSE = 20.0
"""Times the best root mean square residual: beyond, a lens is out of the question."""
CALLS = 300
STEEPEST, ASPECTS = 1.0, (0.5, 2.0)
ENOUGH = 1500
"""Marks that tell roughly where everything is."""
SMOOTH = LensModel("equidistant")
"""Near enough to any lens to compare neighbouring marks by; it images every direction, so that no mark is lost."""


@dataclass(frozen=True, eq=False)
class RingFit:
    """`fit` of `model` to the marks that are in it; `prior_rows` (k, p): what was known before, of unit variance;
    `loads` (n,) of what marks of a line share, None: 1 of each; `of_print`: it is an error of the print [m], not of the
    picture [px].
    """

    model: RingModel
    fit: Fit
    prior_rows: Array
    loads: Array | None = None
    of_print: bool = False

    @property
    def lens(self) -> LensModel:
        return self.model.lens

    def u(self, name: str) -> float:
        return float(self.fit.u[self.fit.names.index(name)])

    def correlation(self, first: str, second: str) -> float:
        i, j = self.fit.names.index(first), self.fit.names.index(second)
        return float(self.fit.covariance[i, j] / (self.fit.u[i] * self.fit.u[j]))

    @property
    def rms(self) -> float:
        """px, of the marks on rings that are used."""
        used = (self.fit.weights > 0) & np.concatenate([marks.ring > 0 for marks in self.model.marks])
        return float(np.sqrt(np.mean(self.fit.residuals[used] ** 2)))


def fit_lens(
    sight: Sight,
    lens: LensModel,
    *,
    start: Array | None = None,
    shared: bool = True,
    of_print: bool = False,
    robust: bool = False,
    bounded: bool = True,
    line_error: float | None = None,
) -> RingFit:
    """`lens`, pixel aspect, principal point and places of the target from all marks together; `shared`: with errors
    that the marks of a line share in a picture, or `of_print` in all pictures, estimated unless `line_error` is their
    standard deviation. Raises InputError where the fit fails
    or, if `bounded`, ends where no target is.
    """
    printed_errors = bool(sight.u_ring)
    model = RingModel(lens, sight.printed, sight.marks, sight.size, sight.square, printed_errors)
    if start is None:
        start = start_values(model, sight.nominal_baseline, principal_point=sight.principal_point)
    prior = _prior(sight, model)
    groups, loads = sight.sight_of_line, sight.enlarged
    if of_print:
        groups, loads = sight.line, model.pixels_per_metre(start)
    fit = least_squares(
        _Patience(model),
        start,
        names=model.names,
        sigma=sight.sigma / np.median(sight.sigma),
        prior=prior,
        groups=groups if shared else None,
        group_loads=loads if shared else None,
        robust=robust,
        group_sigma=line_error if shared else None,
        bounds=_bounds(sight, model) if bounded else None,
    )
    known = np.eye(len(model.names))[[model.names.index(name) for name in prior[0]]]
    return RingFit(model, fit, known / np.sqrt(np.diag(prior[2]))[:, None], loads, of_print)


class _Patience:
    """A model that is asked no more than so often: lenses that fit take 20 to 150 calls, hopeless ones thousands."""

    def __init__(self, model: RingModel) -> None:
        self._model, self._left = model, CALLS

    def __call__(self, values: Array) -> tuple[Array, Array]:
        self._left -= 1
        if self._left < 0:
            raise InputError(f"The fit of the lens {self._model.lens.name} does not converge in {CALLS} steps.")
        return self._model(values)


def final_fit(sight: Sight, ring_fit: RingFit, *, of_print: bool = False) -> RingFit:
    """The same lens once more, without the stretches that disagree, and with errors shared by lines no smaller than
    can be known: where chance has line means scatter less than their noise, the likeliest shared error is none, and
    stated uncertainties would be too small (Chung et al. 2013).
    """
    found = fit_lens(sight, ring_fit.lens, start=ring_fit.fit.values, of_print=of_print, robust=True)
    least = _least_line_error(found, sight.line if of_print else sight.sight_of_line)
    if found.fit.group_sigma >= least:
        return found
    start = found.fit.values
    return fit_lens(sight, ring_fit.lens, start=start, of_print=of_print, robust=True, line_error=least)


def _least_line_error(ring_fit: RingFit, line: NDArray[np.intp]) -> float:
    """The square root of the standard uncertainty of the variance that lines share: of so many line means."""
    fit = ring_fit.fit
    load = np.ones(line.size) if ring_fit.loads is None else ring_fit.loads
    known = np.bincount(line, weights=(fit.weights > 0) * load**2 / fit.sigma**2)
    known = known[known > 0]
    return float(np.sqrt(np.median(1 / known)) * (2 / max(known.size - 2, 1)) ** 0.25)


def stretches(sight: Sight) -> Sight:
    """The marks of all pictures, condensed to a mark for each stretch of a line."""
    few = replace(sight.thinned(ENOUGH), printed=sight.printed._replace(ink_width=0.0))
    return _condensed_by(sight, fit_lens(few, SMOOTH, shared=False, bounded=False))


def _condensed_by(sight: Sight, ring_fit: RingFit) -> Sight:
    """What the width of the ink does is taken away here, once: it bends with the lens, which any fit knows well enough
    for that.
    """
    with_ink = replace(ring_fit.model, marks=sight.marks, printed=sight.printed)
    without = replace(with_ink, printed=sight.printed._replace(ink_width=0.0))
    residuals, as_lines = (model(ring_fit.fit.values)[0] for model in (with_ink, without))
    return replace(condensed(sight, residuals, as_lines), printed=without.printed)


def fit_all(
    sight: Sight, lenses: tuple[LensModel, ...], *, done: Callable[[], None] = lambda: None
) -> tuple[Sight, dict[LensModel, RingFit]]:
    """Every lens that can be fitted, and the marks in stretches with sigmas as they scatter about the best of them.
    Lenses that miss by much more than the best are fitted as well as they can be, without a model of errors.
    """
    short, plain = stretches(sight), {}
    for lens in lenses:
        with suppress(InputError):
            plain[lens] = fit_lens(short, lens, shared=False)
        done()
    if not plain:
        raise InputError(
            "No lens model can be fitted to the marks; check that rings, spokes and ring_spacing are the target's."
        )
    best = min(plain.values(), key=lambda fit: fit.rms)
    short = _condensed_by(sight, best)
    again = fit_lens(short, best.lens, start=best.fit.values, shared=False).fit
    short = evened(short, again.residuals, again.jacobian)
    fits = {lens: _with_shared(short, fit, close=fit.rms <= CLOSE * best.rms) for lens, fit in plain.items()}
    return short, fits


def _with_shared(sight: Sight, plain: RingFit, *, close: bool) -> RingFit:
    if close:
        with suppress(InputError):
            return fit_lens(sight, plain.lens, start=plain.fit.values)
    return plain


def _prior(sight: Sight, model: RingModel) -> tuple[list[str], Array, Array]:
    """What is known before any picture: weak, but for the finder and the stated uncertainty of printed radii."""
    width, height = sight.size
    point = sight.principal_point or middle_of(width, height)
    names, mean = [*CENTRE, "laser.baseline", *FINDER], [*point, sight.nominal_baseline, 0.0, 0.0, 0.0]
    u = [U_CENTRE * width] * 2 + [sight.u_baseline or U_BASELINE * sight.nominal_baseline] + [U_FINDER] * 3
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

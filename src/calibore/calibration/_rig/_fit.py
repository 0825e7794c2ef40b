"""The rig for which its light falls on the known surfaces it was photographed on."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._model import RigModel
from calibore.calibration._rig._start import Prior, first_values, prior_of, rough_values, usable_model
from calibore.errors import InputError
from calibore.fitting import Fit, least_squares
from calibore.rigs import Rig, triangulate
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
SETTLED, ALMOST_ALL = 0.02, 0.9
"""Relative change of what a pixel means in metres, to almost all marks, without which a fit is not repeated."""
MOST_ROUNDS = 5
FEWER = (0.85, 0.7)
"""Fractions of the marks of a look that a fit is content with."""
UNEXPLAINED = 5.0
"""px: marks that stay so far off on the median are lines of something else."""
UNTOLD = 1e-9
"""Of the largest singular value of the scaled Jacobian: directions below are told by nothing."""


@dataclass(frozen=True, eq=False)
class RigFit:
    """`rig` as found, knowing its covariance and degrees of freedom; `fit` in pixels along the marks' directions, its
    first parameters the changes of `model.rig`; `slope` (n,) [m/px] of each gap along its mark's direction;
    `stop_scatter` [m]: standard deviation of what the marks of a stop share, stated or found.
    """

    rig: Rig
    fit: Fit
    model: RigModel
    slope: Array
    stop_scatter: float
    prior: Covariance | None = None
    bounds: Mapping[str, tuple[float, float]] | None = None

    @property
    def free(self) -> tuple[str, ...]:
        return self.model.free

    @property
    def covariance(self) -> Covariance:
        """Of the parameters `free` of the rig."""
        count = len(self.free)
        return Covariance(self.free, self.fit.covariance[:count, :count])

    def with_looks(self, looks: Iterable[Look]) -> "RigFit":
        """The same fit to other looks."""
        return fit_rig(self.model.rig, looks, free=self.free, prior=self.prior, bounds=self.bounds, near=self.rig)

    def radii(self) -> Array:
        """Distances (n,) [m] of all marks from the rig axis."""
        points = [
            triangulate(self.rig, look.u, look.v, laser=look.laser, branch=branch).radius
            for look, branch in zip(self.model.looks, self.model.branches, strict=True)
        ]
        return np.concatenate(points)

    def change(self, name: str) -> tuple[float, float]:
        """How far a parameter was moved, and its standard uncertainty."""
        index = self.fit.names.index(name)
        return float(self.fit.values[index]), float(self.fit.u[index])


def fit_rig(
    rig: Rig,
    looks: Iterable[Look],
    *,
    free: Iterable[str],
    prior: Covariance | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    near: Rig | None = None,
    robust: bool = True,
) -> RigFit:
    """The parameters `free` of `rig` for which the marks of `looks` lie on their references.

    `prior`: what is known of some of them, about their values in `rig`; `bounds` of changes; `near`: where to start, if
    not there. Marks of one stop share
    the error of its reference: as large as that states, or as stops are found to scatter. Raises InputError where the
    evidence does not suffice or the fit fails.
    """
    looks = tuple(replace(look, reference=look.reference.doubting(None)) for look in looks)
    whole = RigModel(rig, looks, tuple(free))
    model, fit, slope = _found(whole, rough_values(whole, near or rig), prior_of(whole, prior), robust=robust)
    doubting, values = model.doubting(fit.values, fit.covariance)
    if doubting.names != model.names:
        model, known = doubting, prior_of(doubting, prior)
        fit, slope = _settled(model, values, known, robust=robust)
    _refuse(fit, model, bounds or {})
    count = len(model.free)
    covariance = Covariance(model.free, fit.covariance[:count, :count])
    freedom = fit.degrees_of_freedom if np.isfinite(fit.degrees_of_freedom) else None
    stated = max((reference.u or 0.0 for reference in model.stops.values()), default=0.0)
    scatter = stated if model.stated else fit.group_sigma
    return RigFit(model.moved_rig(fit.values).knowing(covariance, freedom), fit, model, slope, scatter, prior, bounds)


def _found(whole: RigModel, values: Array, known: Prior | None, *, robust: bool) -> tuple[RigModel, Fit, Array]:
    """The model of the marks used, its fit from `values`, and the slopes (n,) of its marks. Where on the way some come
    over a fold of the light, those next to it are left out.
    """
    for safest in (1.0, *FEWER):
        model = usable_model(whole, values, safest=safest, settled=True)
        try:
            return model, *_settled(model, values, known, robust=robust)
        except InputError:
            if safest == FEWER[-1]:
                raise
    raise AssertionError


def _settled(model: RigModel, values: Array, known: Prior | None, *, robust: bool) -> tuple[Fit, Array]:
    slope = model.residuals(values)[2]
    fit = _fitted(model, values, slope, known, robust=robust)
    for _ in range(MOST_ROUNDS - 1):
        before, slope = slope, model.residuals(fit.values)[2]
        if np.quantile(np.abs(slope / before - 1)[fit.weights > 0], ALMOST_ALL) < SETTLED:
            break
        fit = _fitted(model, fit.values, slope, known, robust=robust)
    return fit, slope


def foreseen(
    rig: Rig, looks: Iterable[Look], *, free: Iterable[str], prior: Covariance | None = None
) -> dict[str, float]:
    """Standard uncertainties of the parameters `free` that a fit would give about the rig as it is, were the marks of
    `looks` as noisy as they say, and errors of references independent; infinite where they tell nothing.
    """
    model = RigModel(rig, tuple(looks), tuple(free))
    values = first_values(model, rig)
    model = usable_model(model, values)
    _, jacobian, slope = model.gaps(values)
    errors = np.zeros((slope.size, len(model.stops)))
    errors[np.arange(slope.size), model.stop_of] = 1.0
    rows = np.concatenate([jacobian, errors], axis=1) / (model.sigma * np.abs(slope))[:, None]
    known = np.zeros((0, rows.shape[1]))
    told = prior_of(model, prior)
    if told is not None:
        root = np.linalg.inv(np.linalg.cholesky(told.matrix))
        known = root @ np.eye(rows.shape[1])[[model.names.index(name) for name in told.names]]
    of_errors = np.eye(rows.shape[1])[len(model.names) :]
    sizes = np.array([reference.u or np.inf for reference in model.stops.values()])
    rows = np.concatenate([rows, known, of_errors[np.isfinite(sizes)] / sizes[np.isfinite(sizes), None]])
    return dict(zip(model.free, _standard_uncertainties(rows).tolist(), strict=False))


def _standard_uncertainties(rows: Array) -> Array:
    """Of parameters (p,) told by `rows` (n, p) of unit variance; infinite where they are not."""
    scale = np.linalg.norm(rows, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, singular, turned = np.linalg.svd(rows / scale, full_matrices=False)
    told = singular > UNTOLD * singular[0]
    variance = np.sum((turned[told] / singular[told, None]) ** 2, axis=0)
    lost = np.sum(turned[~told] ** 2, axis=0) > UNTOLD
    return np.where(lost, np.inf, np.sqrt(variance) / scale)


def _fitted(model: RigModel, values: Array, slope: Array, known: Prior | None, *, robust: bool) -> Fit:
    """With errors of references in metres, of which a pixel is `slope` (n,) [m/px]."""
    u = np.array([reference.u or 0.0 for reference in model.stops.values()])[model.stop_of]
    return least_squares(
        lambda values: model.residuals(values)[:2],
        values,
        names=model.names,
        sigma=model.sigma,
        prior=known,
        groups=model.stop_of,
        group_loads=(u if model.stated else 1.0) / slope,
        group_sigma=1.0 if model.stated else None,
        chains=model.chain_of,
        robust=robust,
    )


def _refuse(fit: Fit, model: RigModel, bounds: Mapping[str, tuple[float, float]]) -> None:
    off = float(np.median(np.abs(fit.residuals)))
    if off > UNEXPLAINED:
        raise InputError(f"Nothing near what was stated explains the pictures: marks stay {off:.0f} px off, typically.")
    for name, u in zip(model.free, fit.u, strict=False):
        if not np.isfinite(u):
            raise InputError(f"The pictures do not tell {name} apart from the other parameters; hold it, or add looks.")
    for name, (low, high) in bounds.items():
        change = fit.value(name)
        if name in model.free and not low < change < high:
            raise InputError(
                f"The fit moves {name} by {change:.4g}, outside {low:.4g} to {high:.4g}: nothing near what was stated "
                "explains the pictures."
            )

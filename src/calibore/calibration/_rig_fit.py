"""The rig for which its light falls on the known surfaces it was photographed on."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._looks import Look
from calibore.calibration._rig_model import ERROR, RigModel, nearest_branches
from calibore.errors import InputError
from calibore.fitting import Fit, least_squares
from calibore.rigs import Rig, margin, triangulate
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
NEAR_FOLD = 25.0
"""Marks of smaller margin are left out: there the radius goes with a root of the pixel, not with the pixel."""
SETTLED = 0.02
"""Weights are settled when a fit with new ones moves no parameter by more of its standard uncertainty."""
MOST_ROUNDS = 5
UNTOLD = 1e-9
"""Of the largest singular value of the scaled Jacobian: directions below are told by nothing."""


@dataclass(frozen=True, eq=False)
class RigFit:
    """`rig` as found, knowing its covariance and degrees of freedom; `fit` in metres, its first parameters the changes
    of `model.rig`; `slope` (n,) [m/px] of each gap along its mark's direction.
    """

    rig: Rig
    fit: Fit
    model: RigModel
    slope: Array
    prior: Covariance | None = None
    bounds: Mapping[str, tuple[float, float]] | None = None

    @property
    def free(self) -> tuple[str, ...]:
        return self.model.free

    @property
    def covariance(self) -> Covariance:
        """Of the parameters `free` of the rig."""
        return self.fit_covariance(self.free)

    def fit_covariance(self, names: Iterable[str]) -> Covariance:
        names = tuple(names)
        index = [self.fit.names.index(name) for name in names]
        return Covariance(names, self.fit.covariance[np.ix_(index, index)])

    def with_looks(self, looks: Iterable[Look]) -> "RigFit":
        """The same fit to other looks."""
        return fit_rig(self.model.rig, looks, free=self.free, prior=self.prior, bounds=self.bounds)

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
    robust: bool = True,
) -> RigFit:
    """The parameters `free` of `rig` for which the marks of `looks` lie on their references.

    `prior`: what is known of some of them, about their values in `rig`; `bounds` of changes. Errors of the references
    are parameters of their own where their uncertainty is stated, else what the stops scatter by is found from the
    residuals. Raises InputError where the evidence does not suffice or the fit fails.
    """
    model = _with_branches(RigModel(rig, tuple(looks), tuple(free)))
    model = _usable(model)
    known, values, rounds = _prior(model, prior), model.start(), 0
    while True:
        slope, before = model.evaluate(values)[2], values
        fit = least_squares(
            model,
            values,
            names=model.names,
            sigma=np.concatenate([look.sigma for look in model.looks]) * np.abs(slope),
            prior=known,
            groups=None if model.stated else model.stop_of,
            chains=model.look_of,
            robust=robust,
            bounds=bounds,
        )
        values, rounds = fit.values, rounds + 1
        if rounds == MOST_ROUNDS or (rounds > 1 and (np.abs(values - before) <= SETTLED * fit.u).all()):
            break
    count = len(model.free)
    covariance = Covariance(model.free, fit.covariance[:count, :count])
    freedom = fit.degrees_of_freedom if np.isfinite(fit.degrees_of_freedom) else None
    return RigFit(model.moved_rig(values).knowing(covariance, freedom), fit, model, slope, prior, bounds)


def foreseen(
    rig: Rig, looks: Iterable[Look], *, free: Iterable[str], prior: Covariance | None = None
) -> dict[str, float]:
    """Standard uncertainties of the parameters `free` that a fit would give about the rig as it is, were the marks of
    `looks` as noisy as they say; infinite where they tell nothing.
    """
    model = _usable(_with_branches(RigModel(rig, tuple(looks), tuple(free))))
    _, jacobian, slope = model.evaluate(model.start())
    rows = jacobian / (np.concatenate([look.sigma for look in model.looks]) * np.abs(slope))[:, None]
    known = _prior(model, prior)
    if known is not None:
        names, _, matrix = known
        root = np.linalg.inv(np.linalg.cholesky(matrix))
        rows = np.concatenate([rows, root @ np.eye(len(model.names))[[model.names.index(name) for name in names]]])
    scale = np.linalg.norm(rows, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, singular, turned = np.linalg.svd(rows / scale, full_matrices=False)
    told = singular > UNTOLD * singular[0]
    variance = np.sum((turned[told] / singular[told, None]) ** 2, axis=0)
    lost = np.sum(turned[~told] ** 2, axis=0) > UNTOLD
    u = np.where(lost, np.inf, np.sqrt(variance) / scale)
    return dict(zip(model.free, u.tolist(), strict=False))


def _with_branches(model: RigModel) -> RigModel:
    """`model` with the meetings nearest to the references: first as they should stand, then as they were set up."""
    model = replace(model, branches=nearest_branches(model, np.zeros(len(model.names))))
    return replace(model, branches=nearest_branches(model, model.start()))


def _usable(model: RigModel) -> RigModel:
    """Only the marks that meet their laser's light, far enough from its folds."""
    looks, branches = [], []
    lit, rig = np.isfinite(model.evaluate(model.start())[0]), model.rig.knowing(None)
    for number, (look, branch) in enumerate(zip(model.looks, model.branches, strict=True)):
        m = margin(rig, look.u, look.v, branch=branch, u_pixel=look.sigma, direction=look.direction, laser=look.laser)
        kept = lit[model.look_of == number] & (m >= NEAR_FOLD)
        if not kept.any():
            raise InputError(
                f"None of the {kept.size} marks of {look.name} lies in the light of the laser as the rig is described; "
                "check its baseline, aim, lens and k, or leave this look out."
            )
        marks = {name: getattr(look, name)[kept] for name in ("u", "v", "direction", "sigma")}
        looks.append(replace(look, **marks))
        branches.append(branch[kept])
    return RigModel(model.rig, tuple(looks), model.free, tuple(branches))


def _prior(model: RigModel, rig: Covariance | None) -> tuple[list[str], Array, Array] | None:
    """What is known before any picture: names, means, covariance matrix."""
    shared = [name for name in model.free if rig is not None and name in rig.names]
    names, variances = list(shared), []
    for setting, reference in model.settings.items():
        for name, u in zip(model.nuisances(setting), reference.nuisance_u, strict=True):
            if np.isfinite(u):
                names.append(name)
                variances.append(u**2)
    names += [f"{stop}.{ERROR}" for stop in model.uncertain_stops]
    variances += [(model.stops[stop].u or 0.0) ** 2 for stop in model.uncertain_stops]
    if not names:
        return None
    matrix = np.zeros((len(names), len(names)))
    if rig is not None and shared:
        matrix[: len(shared), : len(shared)] = rig.restricted(shared).matrix
    matrix[len(shared) :, len(shared) :] = np.diag(variances)
    return names, np.zeros(len(names)), matrix

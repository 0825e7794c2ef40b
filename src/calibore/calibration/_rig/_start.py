"""Where the search for a rig starts: marks that its light explains, what is known, a first look at the values."""

from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._model import RigModel, nearest_branches
from calibore.errors import InputError
from calibore.rigs import Rig, margin, moved, value_of
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
NEAR_FOLD = 25.0
"""Marks of smaller margin are left out: there the radius goes with a root of the pixel, not with the pixel."""
ROUGH, ROUGH_LENGTH, ROUGH_SLOPE, ROUGH_PIXELS = 0.1, 0.02, 0.05, 20.0
"""How well a rig is known at least before a first look: lengths and k relatively, offsets [m], angles [rad],
centre [px]."""
LEAST_SPREAD = 0.2
"""px: marks count as no better than this at folds, which move with the rig while it is looked for."""
MOST_LOOKS, SETTLED, ROUGHLY = 4, 0.02, 1e-5
"""First looks, the last of which changes nothing by more of what is known at least; how exactly each ends."""
SAFEST = 0.6
"""Of the marks of a look, for first looks: a rig that is not yet right takes near meetings for far ones at a fold."""
POOR = 1.5
"""px: marks that are typically so far off are not explained."""
TURNS, MOST_TURNED = (-0.03, -0.015, 0.0, 0.015, 0.03), 4
"""rad: other half angles and aims that are tried then; how many of their combinations."""
LOST = 100.0
"""px: how far off a mark counts at least in a first look that on the way meets no light; more than any that does."""
FAR_WORSE = 3.0


class Prior(NamedTuple):
    """`matrix` (k, k): covariance of the parameters `names` about `mean` (k,) before any picture."""

    names: list[str]
    mean: Array
    matrix: Array


def first_values(model: RigModel, near: Rig) -> Array:
    """Parameters (p,) of the rig `near`, and of references as it sees them: first by the meetings nearest to where they
    would be if they had been set up straight.
    """
    straight = model.start(near)
    straight[len(model.free) :] = 0.0
    return replace(model, branches=nearest_branches(model, straight)).start(near)


def usable_model(model: RigModel, values: Array, *, safest: float = 1.0, settled: bool = False) -> RigModel:
    """Only the marks that at `values` (p,) meet their laser's light far enough from its folds, where it meets
    references, and if `settled` that have a place where they should be; of each look the fraction `safest`.
    """
    try:
        model = replace(model, branches=nearest_branches(model, values))
    except InputError:
        raise InputError("Nothing near the rig as it is described explains the pictures.") from None
    looks, branches = [], []
    value = model.residuals(values)[0] if settled else model.gaps(values).value
    lit, rig = np.isfinite(value), model.moved_rig(values).knowing(None)
    for number, (look, branch) in enumerate(zip(model.looks, model.branches, strict=True)):
        u = np.maximum(look.sigma, LEAST_SPREAD)
        m = margin(rig, look.u, look.v, branch=branch, u_pixel=u, direction=look.direction, laser=look.laser)
        m = np.where(lit[model.look_of == number], np.nan_to_num(m), 0.0)
        kept = m >= max(NEAR_FOLD, np.quantile(m, 1 - safest))
        if not kept.any():
            raise InputError(
                f"None of the {kept.size} marks of {look.name} lies in the light of the laser as the rig is described; "
                "check its baseline, aim, lens and k, or leave this look out."
            )
        marks = {name: getattr(look, name)[kept] for name in ("u", "v", "direction", "sigma")}
        looks.append(replace(look, **marks))
        branches.append(branch[kept])
    return RigModel(model.rig, tuple(looks), model.free, tuple(branches))


def prior_of(model: RigModel, rig: Covariance | None) -> Prior | None:
    """What is known of the rig and of how references were set up."""
    shared = [name for name in model.free if rig is not None and name in rig.names]
    names, variances = list(shared), []
    for setting, reference in model.settings.items():
        for name, u in zip(model.nuisances(setting), reference.nuisance_u, strict=True):
            if np.isfinite(u):
                names.append(name)
                variances.append(u**2)
    if not names:
        return None
    matrix = np.zeros((len(names), len(names)))
    if rig is not None and shared:
        matrix[: len(shared), : len(shared)] = rig.restricted(shared).matrix
    matrix[len(shared) :, len(shared) :] = np.diag(variances)
    return Prior(names, np.zeros(len(names)), matrix)


def rough_values(model: RigModel, near: Rig) -> Array:
    """Parameters (p,) near enough for what a pixel means in metres and which meeting each mark shows: every mark with
    its own slope, all alike good, within what people who build a rig know of it. Where that explains little, other
    angles of cones are tried: of a ring off its place, near meetings pass for far ones.
    """
    values = _roughly(model, near)
    off = _typically_off(model, values)
    if off > POOR:
        for turned in _turned(model, near):
            other = _roughly(model, turned)
            if (other_off := _typically_off(model, other)) < off:
                values, off = other, other_off
            if off < POOR:
                break
    return values


def _roughly(model: RigModel, near: Rig) -> Array:
    from scipy.optimize import least_squares

    values, known = first_values(model, near), _known_at_least(model)
    for _ in range(MOST_LOOKS):
        look, start = _Rough(usable_model(model, values, safest=SAFEST), known), values
        slopes: Any = look.jacobian
        values = least_squares(
            look.residuals, start, slopes, loss="soft_l1", x_scale="jac", xtol=ROUGHLY, ftol=ROUGHLY
        ).x
        if np.abs(known @ (values - start)).max() < SETTLED:
            break
    return values


def _typically_off(model: RigModel, values: Array) -> float:
    """px, median over the marks."""
    try:
        value, _, slope = replace(model, branches=nearest_branches(model, values)).gaps(values)
    except InputError:
        return np.inf
    return float(np.median(np.nan_to_num(np.abs(value / slope), nan=np.inf)))


def _turned(model: RigModel, near: Rig) -> list[Rig]:
    """`near` with other half angles and aims, those first that explain most as they are."""
    names = [name for name in model.free if name.endswith("half_angle")]
    turned = []
    for wider in TURNS if names else ():
        for tipped in TURNS:
            aims = {name.replace("half_angle", "aim"): tipped for name in names}
            changes = dict.fromkeys(names, wider) | {name: turn for name, turn in aims.items() if name in model.free}
            with suppress(InputError):
                turned.append(moved(near, changes))
    return sorted(turned, key=lambda rig: _typically_off(model, first_values(model, rig)))[:MOST_TURNED]


class _Rough:
    """Residuals (n + k,) [px] of marks and of what is `known`, and their Jacobian, at one place after the other."""

    def __init__(self, model: RigModel, known: Array) -> None:
        self._model, self._known = model, known
        self._place = self._jacobian = np.zeros(0)
        self._lost = LOST

    def residuals(self, values: Array) -> Array:
        value, jacobian, slope = self._model.gaps(values)
        residual, by_parameters = value / slope, jacobian / slope[:, None]
        lost = ~np.isfinite(residual)
        self._lost = max(self._lost, FAR_WORSE * float(np.abs(residual[~lost]).max(initial=0.0)))
        residual[lost], by_parameters[lost] = self._lost, 0.0
        self._place, self._jacobian = values.copy(), np.concatenate([by_parameters, self._known])
        return np.concatenate([residual, self._known @ values])

    def jacobian(self, values: Array) -> Array:
        if not np.array_equal(values, self._place):
            self.residuals(values)
        return self._jacobian


def _known_at_least(model: RigModel) -> Array:
    """Rows (k, p) of unit variance: how well rig and references are known before."""
    rough = np.array([_rough(model, name) for name in model.free])
    prior = prior_of(model, Covariance(model.free, np.diag(rough**2)))
    assert prior is not None
    rows = np.zeros((len(prior.names), len(model.names)))
    index = [model.names.index(name) for name in prior.names]
    rows[np.arange(len(index)), index] = 1 / np.sqrt(np.diag(prior.matrix))
    return rows


def _rough(model: RigModel, name: str) -> float:
    key, value = name.rpartition(".")[2], abs(value_of(model.rig, name))
    if key.startswith("principal_point"):
        return ROUGH_PIXELS
    if key in ("k", "baseline") and value > 0:
        return ROUGH * value
    if key in ("baseline", "offset"):
        return ROUGH_LENGTH
    return ROUGH_SLOPE

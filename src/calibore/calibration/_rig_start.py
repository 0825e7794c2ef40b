"""Where the search for a rig starts: marks that its light explains, what is known, a first look at the values."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig_model import RigModel, nearest_branches
from calibore.calibration._rig_values import value_of
from calibore.errors import InputError
from calibore.fitting import least_squares
from calibore.rigs import margin
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
NEAR_FOLD = 25.0
"""Marks of smaller margin are left out: there the radius goes with a root of the pixel, not with the pixel."""
ROUGH, ROUGH_SLOPE, ROUGH_PIXELS = 0.1, 0.05, 20.0
"""How well a rig is known at least before a first look: lengths and k relatively, angles [rad], centre [px]."""


class Prior(NamedTuple):
    """`matrix` (k, k): covariance of the parameters `names` about `mean` (k,) before any picture."""

    names: list[str]
    mean: Array
    matrix: Array


def usable_model(model: RigModel) -> RigModel:
    """Only the marks that meet their laser's light, far enough from its folds, where it meets the references."""
    model = replace(model, branches=nearest_branches(model, np.zeros(len(model.names))))
    model = replace(model, branches=nearest_branches(model, model.start()))
    looks, branches = [], []
    lit, rig = np.isfinite(model.gaps(model.start()).value), model.rig.knowing(None)
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


def rough_values(model: RigModel) -> Array:
    """Parameters (p,) near enough for what a pixel means in metres: every mark with its own slope, all alike good,
    within what people who build a rig know of it.
    """
    start = model.start()

    def in_pixels(values: Array) -> tuple[Array, Array]:
        value, jacobian, slope = model.gaps(values)
        return value / slope, -jacobian / slope[:, None]

    rough = np.array([_rough(model, name) for name in model.free])
    known = prior_of(model, Covariance(model.free, np.diag(rough**2)))
    return least_squares(in_pixels, start, names=model.names, sigma=model.sigma, prior=known, robust=True).values


def _rough(model: RigModel, name: str) -> float:
    key, value = name.rpartition(".")[2], abs(value_of(model.rig, name))
    if key.startswith("principal_point"):
        return ROUGH_PIXELS
    if key in ("k", "baseline") and value > 0:
        return ROUGH * value
    if key in ("baseline", "offset"):
        return ROUGH * float(np.nanmedian(np.linalg.norm(model.points(0), axis=1)))
    return ROUGH_SLOPE

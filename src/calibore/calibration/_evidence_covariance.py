"""The covariance of a calibration, computed again from its FILE and evidence alone."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._file import read_calibration
from calibore.errors import InputError
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]


def recomputed_covariance(path: Path | str) -> Covariance:
    """Covariance of the calibrated parameters of FILE `path` from its residuals' Jacobian and scatter, in the order of
    the file; raises InputError where the evidence is gone or does not hold those parameters.
    """
    calibration = read_calibration(path)
    if not calibration.observations.residual.size:
        raise InputError(
            f"{path} has lost its evidence; its covariance cannot be computed again. Put it back beside it."
        )
    return covariance_of_evidence(calibration)


def covariance_of_evidence(calibration: Calibration) -> Covariance:
    """(J' V^-1 J)^-1 of the observations, V the covariance of their residuals, the groups' errors included."""
    observations, names = calibration.observations, calibration.covariance.names
    absent = [name for name in names if name not in observations.names]
    if absent:
        raise InputError(f"The evidence does not hold {', '.join(absent)}; it belongs to another calibration.")
    rows = observations.whitened if observations.whitened is not None else _white(observations, calibration.group_sigma)
    scale = np.linalg.norm(rows, axis=0)
    _, values, turns = np.linalg.svd(rows / scale, full_matrices=False)
    factor = (turns.T / values / scale[:, None])[[observations.names.index(name) for name in names]]
    return Covariance(names, factor @ factor.T)


def _white(observations: Observations, group_sigma: float) -> Array:
    """The Jacobian (n + g, q) of residuals of one sigma each and g groups, in units of that: V^-1/2 J.

    Within a group V = sigma^2 + group_sigma^2 1 1', so V^-1/2 takes the share `kept` of the weighted mean away.
    """
    used = observations.weight > 0
    weight = np.sqrt(observations.weight[used]) / observations.sigma[used]
    rows, group = observations.jacobian[used] * weight[:, None], observations.group[used]
    if group_sigma == 0:
        return rows
    for number in np.unique(group[group >= 0]):
        own = group == number
        load = weight[own] * group_sigma
        size = float(load @ load)
        share = (1 - 1 / np.sqrt(1 + size)) / size
        rows[own] -= share * np.outer(load, load @ rows[own])
    return rows

"""The covariance of a calibration, computed again from its FILE and evidence alone."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._file._file import read_calibration
from calibore.errors import InputError
from calibore.fitting import least_squares
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]


def recomputed_covariance(path: Path | str) -> Covariance:
    """Covariance of the calibrated parameters of FILE `path` from its residuals and what ties them together, in the
    order of the file: scatter, shared errors and correlated neighbours are estimated anew. Raises InputError where the
    evidence is gone or does not hold those parameters.
    """
    calibration = read_calibration(path)
    if not calibration.observations.residual.size:
        raise InputError(f"{path} has lost its evidence, from which its covariance follows; put it back beside it.")
    return covariance_of_evidence(calibration)


def covariance_of_evidence(calibration: Calibration) -> Covariance:
    """The same of a calibration in memory. At its solution a model is as good as linear in what the covariance says of
    its parameters, so the Jacobian stands for it.
    """
    observations, names = calibration.observations, calibration.covariance.names
    absent = [name for name in names if name not in observations.names]
    if absent:
        raise InputError(f"The evidence does not hold {', '.join(absent)}; it belongs to another calibration.")
    if observations.whitened is not None:
        scale = np.linalg.norm(observations.whitened, axis=0)
        _, values, turns = np.linalg.svd(observations.whitened / scale, full_matrices=False)
        factor = turns.T / values / scale[:, None]
        matrix = factor @ factor.T
    else:
        matrix = _fitted_again(observations)
    index = [observations.names.index(name) for name in names]
    return Covariance(names, matrix[np.ix_(index, index)])


def _fitted_again(observations: Observations) -> Array:
    """Of all parameters, by the fit that the linear model asks for."""
    used = observations.weight > 0
    residual, jacobian = observations.residual[used], observations.jacobian[used]
    size = np.linalg.norm(jacobian / observations.sigma[used][:, None], axis=0)
    size = np.where(size > 0, size, 1.0)

    def model(change: Array) -> tuple[Array, Array]:
        return residual - jacobian @ (change / size), jacobian / size

    fit = least_squares(
        model,
        np.zeros(size.size),
        names=observations.names,
        sigma=observations.sigma[used],
        prior=_prior(observations, size),
        groups=observations.group[used],
        group_loads=_of(observations.load, used),
        chains=_of(observations.chain, used),
        noise=1.0 if observations.known_noise else None,
        group_sigma=observations.known_group_sigma,
    )
    return fit.covariance / np.outer(size, size)


def _of(values: NDArray[Any] | None, used: Rows) -> NDArray[Any] | None:
    return None if values is None else values[used]


def _prior(observations: Observations, size: Array) -> tuple[list[str], Array, Array] | None:
    """Names, mean and covariance of the parameters that were known, in the scale of the fit."""
    if observations.prior is None or not observations.prior.size:
        return None
    rows, aims = observations.prior[:, :-1] / size, observations.prior[:, -1]
    known = np.flatnonzero(np.abs(rows).max(axis=0) > 0)
    inverse = np.linalg.pinv(rows[:, known])
    return [observations.names[i] for i in known], inverse @ aims, inverse @ inverse.T

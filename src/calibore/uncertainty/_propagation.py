"""First-order propagation of a covariance through sensitivities (JCGM 100, eq. 13)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.uncertainty._checks import indices
from calibore.uncertainty._covariance import Covariance

Array = NDArray[np.float64]


class Propagation(NamedTuple):
    """`modes` (m, n), so that the covariance of the n results is `modes.T @ modes`; `u` (n,)."""

    modes: Array
    u: Array


def propagate(sensitivities: Array, covariance: Covariance, *, names: Sequence[str] | None = None) -> Propagation:
    """First-order propagation of `covariance` through `sensitivities` (n, p) = d result / d parameter.

    `names` are the parameters of the columns; without them the columns are those of the covariance, in order.
    Parameters that the covariance does not name are taken as exactly known.
    """
    modes = covariance.factor().T @ matched(sensitivities, covariance, names=names).T
    return Propagation(modes, np.sqrt(np.einsum("mn,mn->n", modes, modes)))


def matched(sensitivities: Array, covariance: Covariance, *, names: Sequence[str] | None) -> Array:
    """The columns (n, p) of `sensitivities` that belong to the covariance's parameters, in its order."""
    if names is not None:
        if sensitivities.shape[1] != len(names):
            raise InputError(f"{len(names)} names do not fit {sensitivities.shape[1]} columns of sensitivities.")
        sensitivities = sensitivities[:, indices(covariance.names, names)]
    if sensitivities.shape[1] != len(covariance.names):
        raise InputError(
            f"{sensitivities.shape[1]} columns of sensitivities do not fit {len(covariance.names)} parameters; "
            "pass names= to choose columns by name."
        )
    return sensitivities

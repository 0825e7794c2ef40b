"""Models compared by what they say of the data: information criteria and data left out."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.fitting._fit import Fit
from calibore.fitting._likelihood import most_likely

Array = NDArray[np.float64]


class Criteria(NamedTuple):
    """Corrected Akaike and Bayesian information criterion; only differences between models of the same data count."""

    aicc: float
    bic: float


def information_criteria(fit: Fit) -> Criteria:
    """Criteria of the mixed model at its greatest (not restricted) likelihood, prior and scatter included.

    Correlated neighbours and errors of groups count in the likelihood for what they are worth, so the number of data
    is that of residuals used; variances and correlations count as parameters. Compare fits of the same residuals
    only: those that one fit leaves out must be left out of the other.
    """
    if fit.evidence is None:
        raise ValueError("Information criteria need a fit of least_squares.")
    model, unknowns, constant = fit.evidence
    deviance = constant + model.at(most_likely(model, unknowns, restricted=False)).deviance(restricted=False)
    data = model.rows + len(model.known)
    free = model.parameters + unknowns.vector(unknowns.start).size
    spare = data - free - 1
    aicc = deviance + 2 * free + 2 * free * (free + 1) / spare if spare > 0 else np.inf
    return Criteria(float(aicc), float(deviance + free * np.log(data)))


def cross_validated(fit_without: Callable[[NDArray[np.bool_]], ArrayLike], folds: ArrayLike) -> float:
    """Root mean square of residuals of data that the fit did not see, in their unit.

    `folds` (n,): the data of one label are left out together; make them what a new picture would be (a ring, a board),
    not single marks. `fit_without(left_out)` fits without the data in the mask `left_out` (n,) and gives the residuals
    of these; NaN are not counted.
    """
    folds = np.asarray(folds)
    if len(np.unique(folds)) < 2:
        raise InputError("Cross-validation needs data in at least 2 parts, got 1; add pictures.")
    squares = np.concatenate([np.asarray(fit_without(folds == fold), dtype=float) ** 2 for fold in np.unique(folds)])
    return float(np.sqrt(np.mean(squares[np.isfinite(squares)])))

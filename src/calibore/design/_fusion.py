"""Several lasers that light the same wall: the better one, or both by minimum variance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import Rule
from calibore.design._prediction import Prediction
from calibore.errors import InputError
from calibore.uncertainty import MEASURABLE_ABOVE, least_variance_weights

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Combined:
    """`u_radius` [m] at every place, with its parts, `weights` (lasers, ...) and `laser`, the heaviest of them (-1
    where none measures).
    """

    u_radius: Array
    u_independent: Array
    u_common: Array
    weights: Array
    laser: NDArray[np.intp]


def combine_lasers(
    predictions: Sequence[Prediction], *, rule: Rule = "minimum-variance", cropped: bool = True
) -> Combined:
    """The radius from all lasers at the same places, of those that measure there.

    "best": the laser of least uncertainty (Swanbom 2007, section 3.3.5). "minimum-variance": weights that make the
    variance least, with what the lasers have in common counted once, not averaged away. Not `cropped`: the edges of the
    image do not count, as in the dissertation's composite profiles.
    """
    if not predictions:
        raise InputError("There is no laser to combine; pass one prediction per laser.")
    seen = (one.measurable if cropped else one.margin > MEASURABLE_ABOVE for one in predictions)
    usable = np.stack([at & np.isfinite(one.u_radius) for at, one in zip(seen, predictions, strict=True)])
    independent = np.where(usable, np.stack([one.of_radius.independent for one in predictions]), 0.0)
    modes = np.where(usable[:, None], np.stack([one.of_radius.modes for one in predictions]), 0.0)
    weights = (
        _best(usable, independent, modes) if rule == "best" else least_variance_weights(independent, modes, usable)
    )
    none = ~usable.any(axis=0)
    parts = np.sqrt(np.square(weights * independent).sum(axis=0))
    shared = np.sqrt(np.square(np.einsum("l...,lm...->m...", weights, modes)).sum(axis=0))
    parts, shared = (np.where(none, np.nan, a) for a in (parts, shared))
    return Combined(
        np.hypot(parts, shared), parts, shared, weights, np.where(none, -1, np.argmax(np.abs(weights), axis=0))
    )


def _best(usable: NDArray[np.bool_], independent: Array, modes: Array) -> Array:
    variance = np.where(usable, independent**2 + np.square(modes).sum(axis=1), np.inf)
    chosen = np.argmin(variance, axis=0)
    return (np.arange(len(usable)).reshape(-1, *(1,) * chosen.ndim) == chosen) & usable

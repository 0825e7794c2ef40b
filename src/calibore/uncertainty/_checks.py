"""What is no covariance is refused with a sentence."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

LARGEST = 1e150  # beyond any unit, and sums and products are still numbers
ROUNDING = 1e-6  # of a correlation coefficient: a covariance printed with six digits


def indices(wanted: Iterable[str], present: Sequence[str]) -> list[int]:
    """Where the `wanted` names stand among those `present`."""
    position = {name: i for i, name in enumerate(present)}
    missing = [name for name in wanted if name not in position]
    if missing:
        raise InputError(f"No parameter is called {', '.join(missing)}; present: {', '.join(present)}.")
    return [position[name] for name in wanted]


def correlation_of(matrix: Array) -> Array:
    """Correlation coefficients (p, p); 0 in the rows and columns of parameters without variance."""
    u = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    divisor = np.where(u > 0, u, 1.0)
    with np.errstate(over="ignore"):  # infinite, and refused as larger than 1
        return matrix / divisor / divisor[:, None]


def check_names(names: tuple[str, ...], matrix: Array) -> None:
    if len(set(names)) < len(names):
        raise InputError(f"Covariance names must be unique, got {', '.join(names)}; name every parameter once.")
    if matrix.shape != (len(names), len(names)):
        raise InputError(
            f"A covariance of {len(names)} parameters has shape {(len(names),) * 2}, got {matrix.shape}; "
            "give one row and one column per parameter."
        )
    if not (np.abs(matrix) <= LARGEST).all():
        raise InputError("A covariance must be finite, got NaN or infinity; leave unknown parameters out.")


def check_definite(names: tuple[str, ...], matrix: Array) -> None:
    variances = np.diag(matrix)
    if (variances < 0).any():
        name = names[int(np.argmin(variances))]
        raise InputError(
            f"The variance of {name} is {variances.min():g}; a variance must not be negative: give the square of its "
            "standard uncertainty."
        )
    if np.any(matrix[variances == 0]) or np.any(matrix[:, variances == 0]):
        raise InputError("A parameter without variance cannot be correlated; give it a variance or zero covariances.")
    correlation = correlation_of(matrix)
    if np.abs(correlation - correlation.T).max(initial=0.0) > ROUNDING:
        raise InputError("A covariance must be symmetric; copy its upper triangle into the lower one.")
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    if values.min(initial=0.0) < -ROUNDING * max(len(names), 1):
        largest = np.abs(vectors[:, 0]) > 0.3 * np.abs(vectors[:, 0]).max()
        raise InputError(
            f"A covariance must be positive semi-definite, but its correlations have the eigenvalue {values[0]:.3g}; "
            f"the correlations of {', '.join(np.array(names)[largest])} contradict each other: "
            "bring them nearer to 0, write them with more digits or compute them anew."
        )


def check_degrees_of_freedom(names: tuple[str, ...], degrees_of_freedom: tuple[float, ...]) -> None:
    if len(degrees_of_freedom) != len(names):
        raise InputError(f"{len(names)} parameters need as many degrees of freedom, got {len(degrees_of_freedom)}.")
    for name, nu in zip(names, degrees_of_freedom, strict=True):
        if not nu > 0:
            raise InputError(
                f"The degrees of freedom of {name} are {nu:g}; they must be above 0: give observations minus fitted "
                "parameters, or leave them out where the uncertainty is well known."
            )


def check_uncertainties(uncertainties: Mapping[str, float]) -> None:
    for name, u in uncertainties.items():
        if not 0 <= u <= np.sqrt(LARGEST):
            raise InputError(
                f"The standard uncertainty of {name} is {u}; it must be finite and not be negative, its square "
                "finite too: give its absolute value, or leave out what is unknown."
            )


def check_correlation(pair: tuple[str, str], r: float) -> None:
    if not -1 <= r <= 1:
        raise InputError(
            f"The correlation of {' and '.join(pair)} is {r}; it must lie between -1 and 1: "
            "give a coefficient, not a covariance or per cent."
        )
    if pair[0] == pair[1] and r != 1:
        raise InputError(f"The correlation of {pair[0]} with itself is 1, got {r}; leave it out.")

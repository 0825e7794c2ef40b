"""The covariance of named parameters, and first-order propagation through sensitivities (JCGM 100, eq. 13)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

ROUNDING = 1e-6  # of a correlation coefficient: a covariance printed with six digits


@dataclass(frozen=True, eq=False)
class Covariance:
    """`matrix` (p, p) of the parameters `names` (p,), in SI; symmetric, positive semi-definite within rounding."""

    names: tuple[str, ...]
    matrix: Array

    def __post_init__(self) -> None:
        names, matrix = tuple(self.names), np.array(self.matrix, dtype=float).reshape(np.shape(self.matrix))
        if len(set(names)) < len(names):
            raise InputError(f"Covariance names must be unique, got {', '.join(names)}; name every parameter once.")
        if matrix.shape != (len(names), len(names)):
            raise InputError(
                f"A covariance of {len(names)} parameters has shape {(len(names),) * 2}, got {matrix.shape}; "
                "give one row and one column per parameter."
            )
        if not np.isfinite(matrix).all():
            raise InputError("A covariance must be finite, got NaN or infinity; leave unknown parameters out.")
        _check_definite(names, matrix)
        matrix = (matrix + matrix.T) / 2
        matrix.flags.writeable = False
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "matrix", matrix)

    @classmethod
    def independent(cls, uncertainties: Mapping[str, float]) -> "Covariance":
        """Of uncorrelated parameters, from their standard uncertainties."""
        u = np.fromiter(uncertainties.values(), dtype=float, count=len(uncertainties))
        if (u < 0).any():
            raise InputError(f"Standard uncertainties must not be negative, got {dict(uncertainties)}.")
        return cls(tuple(uncertainties), np.diag(u**2))

    @property
    def u(self) -> Array:
        """Standard uncertainties (p,)."""
        return np.sqrt(np.diag(self.matrix))

    def factor(self) -> Array:
        """(p, p) with `matrix = factor @ factor.T`, singular matrices included; diagonal where uncorrelated."""
        values, vectors = np.linalg.eigh(_correlation(self.matrix))
        return self.u[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))

    def restricted(self, names: Iterable[str]) -> "Covariance":
        """Of the given parameters only, in that order; raises InputError where one is not here."""
        names = tuple(names)
        index = _indices(names, self.names)
        return Covariance(names, self.matrix[np.ix_(index, index)])

    def joined(self, other: "Covariance") -> "Covariance":
        """Of the parameters of both, uncorrelated with each other."""
        matrix = np.zeros((len(self.names) + len(other.names),) * 2)
        matrix[: len(self.names), : len(self.names)] = self.matrix
        matrix[len(self.names) :, len(self.names) :] = other.matrix
        return Covariance((*self.names, *other.names), matrix)


class Propagation(NamedTuple):
    """`modes` (m, n), so that the covariance of the n results is `modes.T @ modes`; `u` (n,)."""

    modes: Array
    u: Array


def propagate(sensitivities: Array, covariance: Covariance, *, names: Sequence[str] | None = None) -> Propagation:
    """First-order propagation of `covariance` through `sensitivities` (n, p) = d result / d parameter.

    `names` are the parameters of the columns; without them the columns are those of the covariance, in order.
    Parameters that the covariance does not name are taken as exactly known.
    """
    if names is not None:
        sensitivities = sensitivities[:, _indices(covariance.names, names)]
    if sensitivities.shape[1] != len(covariance.names):
        raise InputError(
            f"{sensitivities.shape[1]} columns of sensitivities do not fit {len(covariance.names)} parameters; "
            "pass names= to choose columns by name."
        )
    modes = covariance.factor().T @ sensitivities.T
    return Propagation(modes, np.sqrt(np.einsum("mn,mn->n", modes, modes)))


def _indices(wanted: Iterable[str], present: Sequence[str]) -> list[int]:
    position = {name: i for i, name in enumerate(present)}
    missing = [name for name in wanted if name not in position]
    if missing:
        raise InputError(f"No parameter is called {', '.join(missing)}; present: {', '.join(present)}.")
    return [position[name] for name in wanted]


def _correlation(matrix: Array) -> Array:
    u = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    divisor = np.where(u > 0, u, 1.0)
    return matrix / np.outer(divisor, divisor)


def _check_definite(names: tuple[str, ...], matrix: Array) -> None:
    variances = np.diag(matrix)
    if (variances < 0).any():
        name = names[int(np.argmin(variances))]
        raise InputError(f"The variance of {name} is {variances.min():g}; a variance must not be negative.")
    if np.any(matrix[variances == 0]) or np.any(matrix[:, variances == 0]):
        raise InputError("A parameter without variance cannot be correlated; give it a variance or zero covariances.")
    correlation = _correlation(matrix)
    if np.abs(correlation - correlation.T).max(initial=0.0) > ROUNDING:
        raise InputError("A covariance must be symmetric; copy its upper triangle into the lower one.")
    smallest = np.linalg.eigvalsh((correlation + correlation.T) / 2).min(initial=0.0)
    if smallest < -ROUNDING * max(len(names), 1):
        raise InputError(
            f"A covariance must be positive semi-definite, but its correlations have the eigenvalue {smallest:.3g}; "
            "write it with more digits or compute it anew."
        )

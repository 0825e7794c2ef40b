"""What is known of named inputs: standard uncertainties, correlations, distributions, degrees of freedom."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.uncertainty import _checks as checks
from calibore.uncertainty._distributions import Distribution
from calibore.uncertainty._scores import Scores, scores_of

Array = NDArray[np.float64]
Value = TypeVar("Value")


@dataclass(frozen=True, eq=False, init=False)
class Covariance:
    """`matrix` (p, p) of the parameters `names` (p,), in SI; symmetric, positive semi-definite within rounding.

    `distributions` (p,) are normal where not given, `degrees_of_freedom` (p,) infinite: how well u itself is known.
    First-order propagation needs neither; budgets and Monte Carlo do.
    """

    names: tuple[str, ...]
    matrix: Array
    distributions: tuple[Distribution, ...]
    degrees_of_freedom: tuple[float, ...]

    def __init__(
        self,
        names: Iterable[str],
        matrix: ArrayLike,
        distributions: Iterable[str] | None = None,
        degrees_of_freedom: Iterable[float] | None = None,
    ) -> None:
        names, matrix = tuple(names), np.array(matrix, dtype=float)
        checks.check_names(names, matrix)
        checks.check_definite(names, matrix)
        matrix = (matrix + matrix.T) / 2
        matrix.flags.writeable = False
        shapes = [Distribution.NORMAL] * len(names) if distributions is None else map(Distribution.named, distributions)
        nu = [inf] * len(names) if degrees_of_freedom is None else map(float, degrees_of_freedom)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "distributions", tuple(shapes))
        object.__setattr__(self, "degrees_of_freedom", tuple(nu))
        if len(self.distributions) != len(names):
            raise InputError(f"{len(names)} parameters need as many distributions, got {len(self.distributions)}.")
        checks.check_degrees_of_freedom(names, self.degrees_of_freedom)

    @classmethod
    def independent(
        cls,
        uncertainties: Mapping[str, float],
        *,
        distributions: Mapping[str, str] | None = None,
        degrees_of_freedom: Mapping[str, float] | None = None,
    ) -> "Covariance":
        """Of uncorrelated parameters, from their standard uncertainties."""
        return cls.correlated(uncertainties, {}, distributions=distributions, degrees_of_freedom=degrees_of_freedom)

    @classmethod
    def correlated(
        cls,
        uncertainties: Mapping[str, float],
        correlations: Mapping[tuple[str, str], float],
        *,
        distributions: Mapping[str, str] | None = None,
        degrees_of_freedom: Mapping[str, float] | None = None,
    ) -> "Covariance":
        """From standard uncertainties and the correlation coefficients of pairs; pairs not given are uncorrelated."""
        names = tuple(uncertainties)
        checks.check_uncertainties(uncertainties)
        u = np.fromiter(uncertainties.values(), dtype=float, count=len(names))
        r = np.eye(len(names))
        for pair, coefficient in correlations.items():
            i, j = checks.indices(pair, names)
            checks.check_correlation(pair, coefficient)
            if correlations.get((pair[1], pair[0]), coefficient) != coefficient:
                raise InputError(f"The correlation of {' and '.join(pair)} is given twice and differs; give it once.")
            r[i, j] = r[j, i] = coefficient
        return cls(
            names,
            r * np.outer(u, u),
            _by_name(names, distributions, Distribution.NORMAL),
            _by_name(names, degrees_of_freedom, inf),
        )

    @property
    def u(self) -> Array:
        """Standard uncertainties (p,)."""
        return np.sqrt(np.diag(self.matrix))

    @property
    def correlations(self) -> Array:
        """Correlation coefficients (p, p); rows and columns of parameters without variance are 0."""
        return checks.correlation_of(self.matrix)

    def correlation(self, first: str, second: str) -> float:
        """The correlation coefficient of two parameters."""
        i, j = checks.indices((first, second), self.names)
        return float(self.correlations[i, j])

    def factor(self) -> Array:
        """(p, p) with `matrix = factor @ factor.T`, singular matrices included; diagonal where uncorrelated."""
        values, vectors = np.linalg.eigh(self.correlations)
        return self.u[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))

    @cached_property
    def scores(self) -> Scores:
        """How to draw: everything that a compiled engine needs to do it by itself."""
        return scores_of(self.correlations, self.u, self.distributions, self.degrees_of_freedom)

    def scores_factor(self) -> Array:
        """(p, p): `factor @ standard normals` are normal scores correlated so that the values are as stated."""
        return self.scores.factor

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Random deviations (n, p) from the estimates, with the stated distributions, u and correlations of values.

        Finite degrees of freedom make a normal input t distributed, its standard deviation u sqrt(nu / (nu - 2));
        for nu <= 2 it has none and no number of draws settles. Other distributions are drawn as stated.
        """
        return self.scores.draw(rng, n)

    def restricted(self, names: Iterable[str]) -> "Covariance":
        """Of the given parameters only, in that order; raises InputError where one is not here."""
        names = tuple(names)
        index = checks.indices(names, self.names)
        return Covariance(
            names,
            self.matrix[np.ix_(index, index)],
            [self.distributions[i] for i in index],
            [self.degrees_of_freedom[i] for i in index],
        )

    def joined(self, other: "Covariance") -> "Covariance":
        """Of the parameters of both, uncorrelated with each other."""
        matrix = np.zeros((len(self.names) + len(other.names),) * 2)
        matrix[: len(self.names), : len(self.names)] = self.matrix
        matrix[len(self.names) :, len(self.names) :] = other.matrix
        return Covariance(
            (*self.names, *other.names),
            matrix,
            (*self.distributions, *other.distributions),
            (*self.degrees_of_freedom, *other.degrees_of_freedom),
        )


def _by_name(names: tuple[str, ...], given: Mapping[str, Value] | None, default: Value) -> list[Value]:
    given = given or {}
    checks.indices(given, names)
    return [given.get(name, default) for name in names]

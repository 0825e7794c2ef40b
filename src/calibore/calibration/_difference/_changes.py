"""Which parameters changed: each by itself, and as the only one that did."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._difference._sides import Side, alike
from calibore.uncertainty import Covariance

Array = NDArray[Any]
SINGULAR = 1e-12
"""Of the largest eigenvalue of the correlations: below, directions have no variance."""


class Change(NamedTuple):
    """Of the parameter `name` from `before` to `after` [SI, px]; `u` of the change and how many of them it is,
    `sigmas`, whatever the others did. `alone`: the change that explains most if no other parameter changed, with
    `u_alone`, and the `share` of chi-square that it explains.
    """

    name: str
    before: float
    after: float
    u: float
    alone: float
    u_alone: float
    share: float

    @property
    def change(self) -> float:
        return self.after - self.before

    @property
    def sigmas(self) -> float:
        return self.change / self.u if self.u > 0 else float(np.sign(self.change)) * np.inf if self.change else 0.0

    @property
    def relative(self) -> float:
        """Of the value before; NaN where that was 0."""
        return self.change / self.before if self.before else float("nan")


def changes(a: Side, b: Side) -> tuple[Change, ...]:
    """Of the parameters that both state and that mean the same in both, the one that explains most first.

    Parameters of one calibration are correlated, often by more than 0.99: a change of one of them shows as a change of
    all. By generalised least squares with W = (C_a + C_b)^-1, a change of parameter i alone is (W d)_i / W_ii and takes
    (W d)_i^2 / W_ii off chi-square d' W d.
    """
    names = [name for name in a.values if name in b.values and _meaningful(name, a, b)]
    names = [name for name in names if name in a.covariance.names or name in b.covariance.names]
    if not names:
        return ()
    matrix = _among(a.covariance, names) + _among(b.covariance, names)
    delta = np.array([b.values[name] - a.values[name] for name in names])
    weights = _inverse(matrix)
    pull, strength = weights @ delta, np.diag(weights)
    safe = np.where(strength > 0, strength, 1.0)
    chi_square = float(delta @ pull)
    shares = pull**2 / safe / chi_square if chi_square > 0 else np.zeros(len(names))
    found = (
        Change(name, a.values[name], b.values[name], *map(float, numbers))
        for name, *numbers in zip(names, np.sqrt(np.diag(matrix)), pull / safe, 1 / np.sqrt(safe), shares, strict=True)
    )
    return tuple(sorted(found, key=lambda one: -one.share))


def _meaningful(name: str, a: Side, b: Side) -> bool:
    """Coefficients of a lens mean the same only where all of its coefficients do."""
    return alike(a, b) or not name.startswith(("camera.k", "camera.c1", "camera.c2", "camera.polynomial"))


def _among(covariance: Covariance, names: list[str]) -> Array:
    """(p, p) of `names`, with zeros for those it does not know."""
    index = [names.index(name) for name in covariance.names if name in names]
    matrix = np.zeros((len(names), len(names)))
    matrix[np.ix_(index, index)] = covariance.restricted([names[i] for i in index]).matrix
    return matrix


def _inverse(matrix: Array) -> Array:
    """Of a covariance, over the directions that have variance."""
    u = np.sqrt(np.diag(matrix))
    safe = np.where(u > 0, u, 1.0)
    values, vectors = np.linalg.eigh(matrix / np.outer(safe, safe))
    inverse = np.where(values > SINGULAR * values.max(), 1 / np.where(values > 0, values, 1.0), 0.0)
    return vectors * inverse @ vectors.T / np.outer(safe, safe)

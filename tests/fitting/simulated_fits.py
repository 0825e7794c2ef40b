"""A small calibration that is drawn and fitted many times: a lens law seen through groups of correlated marks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.fitting import Fit, Prior, least_squares

Array = NDArray[np.float64]

NAMES = ("scale", "bend", "tilt")
TRUTH = np.array([1.0, 2.0, -2.0])
START = np.array([0.9, 1.8, -1.0])
PRIOR = np.array([[6e-4, 1e-4], [1e-4, 4e-4]])  # covariance of bend and scale


@dataclass(frozen=True)
class Bench:
    """Marks on `groups` rings, `marks` each: noise `sigma` whose neighbours correlate by `correlation`, and an error
    `group_sigma` that all marks of a ring share.
    """

    groups: int = 10
    marks: int = 20
    sigma: float = 0.03
    correlation: float = 0.0
    group_sigma: float = 0.0
    prior: bool = False

    @property
    def ring(self) -> NDArray[np.intp]:
        return np.repeat(np.arange(self.groups), self.marks)

    def predicted(self, b: Array) -> tuple[Array, Array]:
        """Predictions (n,) and their derivatives (n, 3)."""
        radius = np.linspace(0.3, 1, self.groups)[self.ring]
        wave = 0.1 * radius * np.cos(2 * np.pi * np.arange(self.groups * self.marks) / self.marks)
        sine = 2 * np.sin(radius * b[1])
        slope = 2 * b[0] * radius * np.cos(radius * b[1])
        return b[0] * sine + b[2] * wave, np.column_stack([sine, slope, wave])

    def measured(self, rng: np.random.Generator) -> Array:
        noise = rng.normal(size=(self.groups, self.marks))
        for t in range(1, self.marks):
            fresh = np.sqrt(1 - self.correlation**2)
            noise[:, t] = self.correlation * noise[:, t - 1] + fresh * noise[:, t]
        shared = self.group_sigma * rng.normal(size=self.groups)
        return self.predicted(TRUTH)[0] + self.sigma * noise.ravel() + shared[self.ring]

    def known(self, rng: np.random.Generator) -> Prior:
        return ("bend", "scale"), TRUTH[[1, 0]] + np.linalg.cholesky(PRIOR) @ rng.normal(size=2), PRIOR

    def fit(self, rng: np.random.Generator) -> Fit:
        measured = self.measured(rng)
        return self.fitted(measured, prior=self.known(rng) if self.prior else None)

    def fitted(self, measured: Array, *, prior: Prior | None = None, robust: bool = False) -> Fit:
        def model(b: Array) -> tuple[Array, Array]:
            prediction, jacobian = self.predicted(b)
            return measured - prediction, jacobian

        return least_squares(
            model,
            START,
            names=NAMES,
            prior=prior,
            groups=self.ring if self.group_sigma else None,
            chains=self.ring if self.correlation else None,
            robust=robust,
        )

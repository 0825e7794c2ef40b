"""Levenberg and Marquardt's search on a QR of the column-scaled Jacobian (MINPACK's lmder, through SciPy)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]
Function = Callable[[Array], tuple[Array, Array]]

EXACT = (1e-10, 2.3e-16)  # a step of the scaled parameters, a decrease of the sum of squares that end the search
ROUGH = (1e-4, 1e-6)  # the same for a fit that another will follow
EVALUATIONS = 2000
REPULSIVE = 1e3  # times the first residual: what a step costs that ends where the model has no value
UNFINISHED = 1e-4  # of the sum of squares that a step could still take away


class _Search:
    """The function as MINPACK asks for it: residuals, then the Jacobian at the same place; never NaN."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._place: Array | None = None
        self._wall: float | None = None
        self.refusals = 0

    def residuals(self, values: Array) -> Array:
        self._evaluate(values)
        return self._residuals

    def jacobian(self, values: Array) -> Array:
        self._evaluate(values)
        return self._jacobian

    def _evaluate(self, values: Array) -> None:
        if self._place is not None and np.array_equal(values, self._place):
            return
        with np.errstate(all="ignore"):
            residuals, slopes = self._function(values)
        if not (np.isfinite(residuals).all() and np.isfinite(slopes).all()):
            if self._wall is None:
                raise InputError("The fit starts where the model has no value; start nearer.")
            self.refusals += 1
            residuals, slopes = np.full(residuals.shape, self._wall), np.zeros(slopes.shape)
        elif self._wall is None:
            self._wall = REPULSIVE * (float(np.abs(residuals).max(initial=0)) + 1)
        self._place, self._residuals, self._jacobian = values.copy(), residuals, -slopes


def minimise(function: Function, start: Array, *, rough: bool = False) -> Array:
    """Parameters (p,) with the least sum of squares of the residuals (n,) of `function`, which gives them and the
    Jacobian (n, p) of the predictions. A step to where it has no value is refused. Raises InputError where the search
    does not converge.
    """
    from scipy.optimize import least_squares

    search = _Search(function)
    step, decrease = ROUGH if rough else EXACT
    found = least_squares(
        search.residuals,
        start,
        jac=search.jacobian,  # pyright: ignore[reportArgumentType]
        method="lm",
        x_scale="jac",
        xtol=step,
        ftol=decrease,
        gtol=EXACT[1],
        max_nfev=EVALUATIONS,
    )
    if found.status <= 0:
        raise InputError(
            f"The fit did not converge in {EVALUATIONS} steps; start nearer, fit fewer parameters or add data that "
            "tell them apart."
        )
    if search.refusals:
        _check_finished(*function(found.x))
    return found.x


def _check_finished(residuals: Array, jacobian: Array) -> None:
    scale = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(scale > 0, scale, 1)
    fitted = scaled @ np.linalg.lstsq(scaled, residuals)[0]
    if fitted @ fitted > UNFINISHED * (residuals @ residuals):
        raise InputError("The fit ends where the model has no value for some data; leave them out or start nearer.")

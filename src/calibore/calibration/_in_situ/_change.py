"""Whether a calibration is still tenable: the parameters found in the pipe against those in use."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._fit import RigFit
from calibore.rigs import values_of
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
TENABLE = 0.05
"""Below this probability of chance the old calibration is given up."""


@dataclass(frozen=True, eq=False)
class Change:
    """From `before` to `after` (q,) of the parameters `names`, standard uncertainties `u_before`, `u_after` and `u` of
    the difference; `chi_square` of all together with `degrees_of_freedom` for its scatter, and probability `p` of at
    least as much by chance.
    """

    names: tuple[str, ...]
    before: Array
    after: Array
    u_before: Array
    u_after: Array
    u: Array
    chi_square: float
    degrees_of_freedom: float
    p: float

    @property
    def sigmas(self) -> Array:
        """The changes (q,) in units of their standard uncertainty."""
        return (self.after - self.before) / np.where(self.u > 0, self.u, np.nan)

    @property
    def tenable(self) -> bool:
        return self.p >= TENABLE


def change_of(found: RigFit, names: Iterable[str], *, old: Covariance) -> Change:
    """Of the parameters `names` that were found from the pipe alone, while the other free ones were known by `old`.

    What `old` says of the others has moved the new values too: with the gain G of the others' prior,
    var(new - old) = C_new + C_old - G C_others,old - its transpose.
    """
    names = tuple(names)
    rig = found.model.rig
    before, after = (np.array(list(values_of(one, names).values())) for one in (rig, found.rig))
    new = found.covariance.restricted(names).matrix
    had = _of(old, names, names)
    others = [name for name in found.free if name not in names and name in old.names]
    gained = np.zeros_like(new)
    if others:
        both = found.covariance.restricted((*names, *others)).matrix
        q = len(names)
        gained = both[:q, q:] @ np.linalg.solve(_of(old, others, others), _of(old, others, names))
    spread = new + had - gained - gained.T
    scale = np.sqrt(np.diag(spread))
    weighted = np.linalg.inv(spread / np.outer(scale, scale)) / np.outer(scale, scale)
    chi_square = float((after - before) @ weighted @ (after - before))
    freedom = _freedom(found, names, share=float(np.trace(weighted @ new)) / len(names))
    return Change(
        names,
        before,
        after,
        np.sqrt(np.diag(had)),
        np.sqrt(np.diag(new)),
        scale,
        chi_square,
        freedom,
        _by_chance(chi_square, len(names), freedom),
    )


def _of(covariance: Covariance, rows: Iterable[str], columns: Iterable[str]) -> Array:
    """The block of a covariance, 0 for parameters it does not know."""
    known = {name: i for i, name in enumerate(covariance.names)}
    return np.array(
        [[covariance.matrix[known[r], known[c]] if r in known and c in known else 0.0 for c in columns] for r in rows]
    )


def _freedom(found: RigFit, names: tuple[str, ...], *, share: float) -> float:
    """Degrees of freedom of the difference, of whose variance the new fit has this `share` (Welch, Satterthwaite)."""
    unit = np.eye(len(found.fit.names))
    least = min(found.fit.degrees_of_freedom_of(unit[found.fit.names.index(name)]) for name in names)
    return least / share**2 if share > 0 else np.inf


def _by_chance(chi_square: float, q: int, freedom: float) -> float:
    from scipy.special import chdtrc, fdtrc

    if not np.isfinite(freedom):
        return float(chdtrc(q, chi_square))
    return float(fdtrc(q, freedom, chi_square / q))

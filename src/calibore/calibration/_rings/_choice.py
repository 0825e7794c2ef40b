"""Lens models compared by what they say of rings and sectors that they have not seen, and the one to use."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import LensModel
from calibore.calibration._rings._fit import RingFit
from calibore.calibration._rings._sight import Sight
from calibore.fitting import information_criteria

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

SECTORS = 6
SIGNIFICANT = 2.0
"""Standard errors by which the squared errors of left-out rings must differ."""
RELEVANT = 1.05
"""Times the least error of left-out rings: less is no reason for another parameter."""
CLOSE = 4.0
"""Of Akaike's criterion: less is no reason for another parameter either."""
DETERMINED = 0.05
"""Relative standard uncertainty of k and D above which they are not determined."""
BASELINE, SCALE = "laser.baseline", "camera.k"


@dataclass(frozen=True, eq=False)
class Trial:
    """A fitted lens and its errors where marks are left out: `rings` (r,) one by one, which tells how it interpolates
    and extrapolates, mean squares in units of the marks' sigma; `rms` [px] of all of them, `sectors` [px] where sixths
    of the picture are left out; criteria absolute.
    """

    ring_fit: RingFit
    rings: NDArray[Any]
    rms: float
    sectors: float
    aicc: float
    bic: float

    @property
    def lens(self) -> LensModel:
        return self.ring_fit.lens

    @property
    def relative_u(self) -> float:
        """The larger relative standard uncertainty of D and k."""
        fit = self.ring_fit.fit
        return max(self.ring_fit.u(name) / fit.value(name) for name in (BASELINE, SCALE))


def tried(ring_fit: RingFit, sight: Sight) -> Trial:
    """The errors of the marks of `sight` where rings or sectors are left out."""
    weight = _weights(ring_fit, sight.sight_of_line)
    ring = np.where(sight.on_ring, sight.line, 0)
    sector = ((sight.azimuth + np.pi) * (SECTORS / (2 * np.pi))).astype(int) % SECTORS
    rings = [_left_out(ring_fit, np.flatnonzero(ring == one), weight) for one in np.unique(ring[ring > 0])]
    sectors = [_left_out(ring_fit, np.flatnonzero(sector == one), weight) for one in range(SECTORS)]
    chi = np.array([np.mean((errors / sight.sigma[rows]) ** 2) for rows, errors in rings])
    rms, sector_rms = (
        float(np.sqrt(np.mean(np.concatenate([errors[sight.on_ring[rows]] for rows, errors in folds]) ** 2)))
        for folds in (rings, sectors)
    )
    return Trial(ring_fit, chi, rms, sector_rms, *information_criteria(ring_fit.fit))


def _left_out(ring_fit: RingFit, rows: Whole, weight: Array) -> tuple[Whole, Array]:
    """The marks `rows` (m,) and how far a fit without them misses them [px], by one step of Gauss and Newton."""
    fit = ring_fit.fit
    others = np.sqrt(np.delete(weight, rows))
    table = np.concatenate([np.delete(fit.jacobian, rows, axis=0) * others[:, None], ring_fit.prior_rows])
    scale = np.linalg.norm(table, axis=0)
    right = np.concatenate([np.delete(fit.residuals, rows) * others, np.zeros(len(ring_fit.prior_rows))])
    change = np.linalg.lstsq(table / scale, right)[0] / scale
    return rows, fit.residuals[rows] - fit.jacobian[rows] @ change


def _weights(ring_fit: RingFit, line: Whole) -> Array:
    """(n,) of marks whose line errs as a whole: what is known of a line does not grow with its marks without end."""
    fit = ring_fit.fit
    load = 1.0 if ring_fit.loads is None else ring_fit.loads
    alone = (fit.weights > 0) / fit.sigma**2
    shared = np.bincount(line, weights=alone * load**2) * fit.group_sigma**2
    return alone / (1 + shared[line])


def recommended(trials: list[Trial]) -> Trial:
    """The simplest lens whose errors of left-out rings are not significantly worse than the least, or that Akaike's
    criterion does not rule out; of equally simple ones the one that criterion prefers. Errors of left-out rings tell
    whether a lens describes them at all; the criterion knows what marks and rings are worth, and decides closer calls.
    """
    tried_alike = [trial for trial in trials if trial.ring_fit.loads is not None] or trials
    best, likeliest = min(tried_alike, key=lambda t: t.rms), min(trial.aicc for trial in tried_alike)
    tenable = [trial for trial in tried_alike if not worse(trial, best) or trial.aicc < likeliest + CLOSE]
    simplest = min(len(trial.lens.parameters) for trial in tenable)
    return min((trial for trial in tenable if len(trial.lens.parameters) == simplest), key=lambda trial: trial.aicc)


def worse(trial: Trial, best: Trial) -> bool:
    """Whether `trial` misses left-out rings significantly, and by more than matters. Sectors do not count: what rings
    err by as a whole is seen by the other sectors, and a lens that follows it would be preferred.
    """
    difference = trial.rings - best.rings
    error = difference.std(ddof=1) / np.sqrt(difference.size)
    return trial.rms > RELEVANT * best.rms and bool(difference.mean() > SIGNIFICANT * error)

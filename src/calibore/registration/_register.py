"""Two profiles of one pipe brought into one frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.registration._astray import Walk
from calibore.registration._gaps import Cloud, Gaps, residual_of
from calibore.registration._motion import Motion
from calibore.registration._solve import Freedom, Solution, solved, told
from calibore.registration._start import starts
from calibore.registration._surface import Surface
from calibore.scans import Profile
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]

RIGID = ("roll", "shift_x", "shift_y", "axial", "tilt_x", "tilt_y")
SINGLE_RING = ("roll", "shift_x", "shift_y")
"""What one ring, or a reference of one ring, can tell."""
U_ROLL, U_SHIFT, U_SLOPE, U_SCALE = np.radians(10.0), 0.05, 0.05, 0.02
"""Prior standard deviations: roll [rad], shift over the radius, slopes, stretch and scale. What the profiles do not
tell stays about as uncertain as this."""
STATIONS = 2.0
"""Spacings of the coarser profile: prior standard deviation of the axial shift."""
WALK_ROLL, WALK_SHIFT = np.radians(0.1), 0.002
"""By which roll [rad], and shift over the radius, of a ring may differ from the next one's where rings move alone."""
TOLD = 0.5
"""Of its prior standard deviation: a parameter known no better is not told by the profiles."""


@dataclass(frozen=True, eq=False)
class Registration:
    """`motion` from the moving profile's frame into the reference's; `covariance` of what was free in it, calibration
    of both profiles included; `untold`: names of parameters that the profiles do not tell; `drift` (n, 3) of single
    rings beyond it (roll [rad], shifts [m]) with `u_drift`, None where rings do not move alone.

    `modes` (q,) of the moving profile's, then the reference's common modes as they suit best, N(0, 1) before; `joint`:
    covariance of free parameters, drifts and modes. `gaps` between points and reference; `cloud` the points; robust
    `weights` (p,), `scatter` of residuals over what the profiles state, `points`: independent ones they are worth;
    `correlation` (k,) of residuals of neighbouring clock positions. `table` (p, s): slopes of the residuals by what
    `joint` is the covariance of.
    """

    motion: Motion
    covariance: Covariance
    untold: tuple[str, ...]
    drift: Array | None
    modes: Array
    joint: Array
    gaps: Gaps
    cloud: Cloud
    weights: Array
    scatter: float
    points: float
    correlation: Array
    table: Array
    u_drift: Array | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What was free."""
        return self.covariance.names

    def u(self, name: str) -> float:
        """Standard uncertainty of a parameter of the motion, 0 of one that was held."""
        return float(self.covariance.u[self.names.index(name)]) if name in self.names else 0.0

    @property
    def degrees_of_freedom(self) -> float:
        """Independent points less parameters."""
        return max(self.points - len(self.names), 1.0)


def register(
    moving: Profile,
    reference: Profile,
    *,
    free: Sequence[str] = RIGID,
    start: Motion | None = None,
    per_ring: bool = False,
    search: bool = True,
) -> Registration:
    """Brings `moving` onto `reference`, from any `start` within 10 deg, 5 % of the radius and two stations.

    `free` parameters of the motion (none: it is known), others stay as in `start`; `per_ring`: each ring may in
    addition turn and shift, smoothly from ring to ring; `search` False: the start is near already. Raises InputError
    where the two cannot be brought together: no overlap, no common shape (AstrayError).
    """
    _check(free)
    about = (start or Motion()).about(float(np.nanmedian(moving.axial_position)))
    cloud, surface = Cloud.of(moving), Surface(reference)
    freedom = _freedom(moving, reference, free, per_ring=per_ring)
    spacing = max(moving.spacing, reference.spacing)
    candidates = [about]
    if search and {"roll", "axial"} & set(freedom.names):
        found = starts(cloud, surface, about, spacing=spacing, scaled=True)
        candidates = [replace(one.motion, scale=about.scale) for one in found]
    if not candidates:
        raise InputError(_no_overlap(moving, reference))
    left = freedom.only(told(cloud, surface, candidates[0], freedom.names))
    if free and not left.names:
        raise InputError("The profiles tell none of the parameters that are free; name more of them in free.")
    held = {name: getattr(about, name) for name in freedom.names if name not in left.names}
    candidates = [replace(one, **held) for one in candidates[: 1 if held else None]]
    best = _best(cloud, surface, candidates, left, about)
    found = _registration(best, cloud, left, freedom)
    _walk(found, cloud, surface, about, freedom).check()
    return found


def _walk(found: Registration, cloud: Cloud, surface: Surface, about: Motion, freedom: Freedom) -> Walk:
    told = [name for name in freedom.names if name not in found.untold]
    there = residual_of(cloud, surface, about)[0]
    return Walk(
        {name: getattr(found.motion, name) - getattr(about, name) for name in told},
        dict(zip(freedom.names, freedom.prior.tolist(), strict=True)),
        {name: found.u(name) for name in told},
        int(np.count_nonzero(np.isfinite(there))),
        int(np.count_nonzero(np.isfinite(found.gaps.residual))),
        found.scatter,
    )


def _check(free: Sequence[str]) -> None:
    unknown = sorted(set(free) - set(Motion.names))
    if unknown:
        raise InputError(f"A motion has no {unknown[0]}; free may name {', '.join(Motion.names)}.")


def _freedom(moving: Profile, reference: Profile, free: Sequence[str], *, per_ring: bool) -> Freedom:
    if reference.axial.size == 1 or moving.axial.size == 1:
        free = [name for name in free if name in (*SINGLE_RING, "scale", "axial")]
        free = [name for name in free if name != "axial" or reference.axial.size > 1]
    names = tuple(name for name in Motion.names if name in free)
    radius = reference.typical_radius
    axial = STATIONS * max(moving.spacing, reference.spacing, U_SHIFT * radius)
    prior = dict.fromkeys(("tilt_x", "tilt_y"), U_SLOPE) | dict.fromkeys(("stretch", "scale"), U_SCALE)
    prior |= {"roll": U_ROLL, "shift_x": U_SHIFT * radius, "shift_y": U_SHIFT * radius, "axial": axial}
    walk = np.array([WALK_ROLL, WALK_SHIFT * radius, WALK_SHIFT * radius]) if per_ring else None
    return Freedom(names, np.array([prior[name] for name in names]), walk)


def _best(cloud: Cloud, surface: Surface, candidates: list[Motion], freedom: Freedom, about: Motion) -> Solution:
    """Every candidate refined; the one under which residuals are likeliest."""
    found, problem = [], InputError("")
    for candidate in candidates:
        try:
            found.append(solved(cloud, surface, candidate, freedom, about=about))
        except InputError as error:
            problem = error
    if not found:
        raise problem
    return min(found, key=lambda one: one.cost)


def _registration(best: Solution, cloud: Cloud, left: Freedom, freedom: Freedom) -> Registration:
    """`left` free after what the profiles do not tell of `freedom` was held."""
    count = len(left.names)
    matrix = np.diag(freedom.prior**2)
    rows = [freedom.names.index(name) for name in left.names]
    matrix[np.ix_(rows, rows)] = best.covariance[:count, :count]
    covariance = Covariance(freedom.names, matrix)
    untold = tuple(
        name for name, u, prior in zip(freedom.names, covariance.u, freedom.prior, strict=True) if u > TOLD * prior
    )
    u_drift = None
    if best.drift is not None:
        u_drift = np.sqrt(np.diag(best.covariance)[count : count + best.drift.size].reshape(best.drift.shape))
    return Registration(
        best.motion,
        covariance,
        untold,
        best.drift,
        best.modes,
        best.covariance,
        best.gaps,
        cloud,
        best.weights,
        best.scatter,
        best.points,
        best.correlation,
        best.table,
        u_drift,
    )


def _no_overlap(moving: Profile, reference: Profile) -> str:
    spans = [
        f"{1e3 * np.nanmin(one.axial_position):.4g} to {1e3 * np.nanmax(one.axial_position):.4g} mm"
        for one in (moving, reference)
    ]
    return (
        f"The profiles do not overlap along the pipe: one covers {spans[0]}, the reference {spans[1]}; check the "
        "origins of their motion tables, or give a start."
    )

"""What two profiles that should be compared may have wrong with them, each in a sentence for whoever measured them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.comparison._axial_units import thinned, wrong_axial_units
from calibore.comparison._difference import Difference
from calibore.errors import InputError
from calibore.registration import AstrayError, Cloud, Motion, Surface, gaps, register
from calibore.scans import Profile

Array = NDArray[np.float64]
Names = tuple[str, str]
"""What people call the moving profile and the reference."""

FACTORS = {
    25.4: "inches read as millimetres",
    12.0: "feet read as inches",
    3.2808: "metres read as feet, or feet as metres",
    39.37: "metres read as inches",
    1000.0: "metres read as millimetres",
    100.0: "metres read as centimetres",
    10.0: "centimetres read as millimetres",
    2.54: "inches read as centimetres",
    2.0: "diameters read as radii",
}
NEAR_FACTOR = 0.03
"""Relative; two instruments in one pipe agree better on its radius."""
SAME_PIPE = 1.25
"""Ratio of median radii beyond which no single pipe was measured."""
BEYOND = 5.0
"""Standard deviations of noise beyond which a difference is none of chance."""
MANY = 0.25
"""Of the points beyond: then it is asked whether something is wrong with the pair."""
MIRROR = 3.0
"""Times better a mirrored profile must fit to be called mirrored."""
ODD, TELLING = 0.03, 3
"""Share of points beyond, and rings with a counterpart: with more, or fewer of them, it is asked whether positions
along the pipe are right."""
ALIKE, WHOLE = 0.65, (0.8, 1.25)
"""Correlation of the shapes of two walls below which they may be different pipes; they are not where all of one wall's
shape, within these limits, is found in the other: then one of them has changed."""
FITS = 10.0
"""Times its noise: what most of a mirrored profile may be off where the direct one tells nothing."""
FEWEST = 30
"""Points in common without which nothing is registered."""
KEPT = 0.25
"""Of the points in common before registration: one that leaves fewer has slid off a wall that it does not fit."""
SHAPED = 3.0
"""Standard uncertainties by which a wall's shape must stand out for that to be asked."""


def check_pair(moving: Profile, reference: Profile, names: Names) -> None:
    """Before registration: raises InputError where radii differ by a factor of units, or are no single pipe's."""
    ratio = moving.typical_radius / reference.typical_radius
    size = max(ratio, 1 / ratio)
    radii = (
        f"the median radius of {names[0]} is {1e3 * moving.typical_radius:.4g} mm, "
        f"that of {names[1]} {1e3 * reference.typical_radius:.4g} mm"
    )
    for factor, why in FACTORS.items():
        if abs(size / factor - 1) <= NEAR_FACTOR:
            raise InputError(
                f"Radii differ by a factor of {factor:.4g}: {radii}; probably wrong units ({why}), else different "
                "pipes. Check the units in rig.toml, scan.toml and tables."
            )
    if size > SAME_PIPE:
        raise InputError(f"These are different pipes: {radii}; compare scans of one pipe.")


def comparable(moving: Profile, reference: Profile, start: Motion | None) -> int:
    """How many points of the moving profile lie on the reference before anything is registered."""
    left = gaps(Cloud.of(moving), Surface(reference), start or Motion()).residual
    return int(np.count_nonzero(np.isfinite(left)))


def why_not_registered(
    moving: Profile, reference: Profile, names: Names, *, common: int, error: InputError
) -> InputError:
    """A better sentence than `error` for two that have `common` points before registration."""
    if wrong := wrong_axial_units(moving, reference, names):
        return wrong
    spans = [(float(np.nanmin(p.axial_position)), float(np.nanmax(p.axial_position))) for p in (moving, reference)]
    low, high = max(spans[0][0], spans[1][0]), min(spans[0][1], spans[1][1])
    said = [
        f"{name} has points from {1e3 * a:.4g} to {1e3 * b:.4g} mm" for name, (a, b) in zip(names, spans, strict=True)
    ]
    if low > high:
        return InputError(
            f"The two do not overlap along the pipe: {said[0]}, {said[1]}. Check the origins of their motion tables, "
            'or give --start "axial=...".'
        )
    if common < FEWEST:
        return InputError(
            f"Where the two overlap along the pipe, {1e3 * low:.4g} to {1e3 * high:.4g} mm, hardly a point has a value "
            f"in both; {said[0]}, {said[1]}. Check why the points are missing there (status in profile.zarr)."
        )
    if not isinstance(error, AstrayError):
        return error
    try:
        _check_clock(moving, reference, names)
    except InputError as mirror:
        return mirror
    return _different(names, error.found)


def _different(names: Names, found: str) -> InputError:
    return InputError(
        f"{names[0]} and {names[1]} are different pipes, or turned by more than 10 deg against each other: {found}. "
        'Compare scans of one pipe, or give --start "roll=... deg".'
    )


def check_outcome(
    difference: Difference, moving: Profile, reference: Profile, names: Names, *, common: int
) -> tuple[str, ...]:
    """After registration of two that had `common` points before: warnings; raises InputError where clocks run against
    each other or pipes are different.
    """
    value = difference.adjusted
    noise = np.hypot(difference.u_independent, difference.missed)
    known = np.isfinite(value) & np.isfinite(noise)
    count = np.count_nonzero(known)
    beyond = float(np.mean(np.abs(value[known]) > BEYOND * noise[known])) if count else 1.0
    _check_axial(moving, reference, names, known=known, beyond=beyond)
    if count < KEPT * common:
        _check_clock(moving, reference, names)
        found = f"they fit best where {count} points have a counterpart, of {common} before"
        raise _different(names, found)
    if beyond < MANY:
        return ()
    left = _size(value[known])
    searched = _check_clock(moving, reference, names)
    if left > MIRROR * searched:
        return (
            f"The motion that was given leaves {left / searched:.0f} times more than one that is searched for: check "
            "its values, or leave out --no-search and --free none.",
        )
    _check_shape(difference, known, names, left)
    return (
        f"{100 * beyond:.0f} % of the points differ by more than {BEYOND:.0f} times their noise: the wall has changed "
        "nearly everywhere, or one of the calibrations is wrong, or these are different pipes.",
    )


def _check_axial(moving: Profile, reference: Profile, names: Names, *, known: NDArray[np.bool_], beyond: float) -> None:
    """Raises InputError where positions along the pipe are in wrong units; few rings may fit anywhere."""
    few = np.count_nonzero(known.any(axis=1)) < TELLING
    if not few and beyond < ODD:
        return
    wrong = wrong_axial_units(moving, reference, names, beyond=1.0 if few else beyond)
    if wrong:
        raise wrong


def mirrored(profile: Profile) -> Profile:
    """The profile as an instrument sees it whose clock runs the other way round."""
    turned = np.mod(-profile.clock, 2 * np.pi)
    order = np.argsort(turned, kind="stable")
    grids = {n: getattr(profile, n)[..., order] for n in ("radius", "axial_position", "u_independent", "status")}
    return replace(profile, clock=turned[order], common_mode=profile.common_mode[..., order], **grids)


def _check_clock(moving: Profile, reference: Profile, names: Names) -> float:
    """Raises InputError where the mirrored profile fits far better, both searched for; what is left of the direct
    one [m], inf where it does not fit at all.
    """
    few = thinned(moving)
    (direct, _), (turned, noise) = (_left_after(one, reference) for one in (few, mirrored(few)))
    if direct > MIRROR * turned and (np.isfinite(direct) or turned < FITS * noise):
        times = f"{direct / turned:.0f} times better" if np.isfinite(direct) else "and otherwise not at all"
        raise InputError(
            f"{names[0]} runs against the clock of {names[1]}: mirrored it fits {times}. Check which way round "
            "columns, rotation or image of either are; clocks count clockwise looking along travel."
        )
    return direct


def _left_after(moving: Profile, reference: Profile) -> tuple[float, float]:
    """Size of what registration leaves and of the noise in it [m]; inf where most points have no counterpart then."""
    try:
        found = register(moving, reference, free=("roll", "shift_x", "shift_y", "axial")).gaps
    except InputError:
        return np.inf, 0.0
    used = np.isfinite(found.residual)
    if np.count_nonzero(used) < KEPT * used.size:
        return np.inf, 0.0
    return _size(found.residual[used]), float(np.median(np.sqrt(found.total[used])))


def _size(values: Array) -> float:
    """Of most values: features that differ must not decide, but most of a wall must."""
    return float(np.quantile(np.abs(values), 0.9))


def _check_shape(difference: Difference, known: NDArray[np.bool_], names: Names, left: float) -> None:
    """Whether either wall shows the other's own shape: what remains of its radii without centre and size."""
    moved = np.where(known, difference.radius, np.nan)
    own, other = _shape(moved, difference.clock), _shape(moved - difference.value, difference.clock)
    used = np.isfinite(own) & np.isfinite(other)
    if not used.any():
        return
    noise = float(np.sqrt(np.mean(difference.u_independent[used] ** 2)))
    sizes = [float(np.sqrt(np.mean(one[used] ** 2))) for one in (own, other)]
    shared = float(np.mean(own[used] * other[used]))
    whole = any(WHOLE[0] < shared / size**2 < WHOLE[1] for size in sizes)
    if min(sizes) > SHAPED * noise and shared < ALIKE * sizes[0] * sizes[1] and not whole:
        raise _different(
            names,
            f"brought together as well as can be, they still differ by up to {1e3 * left:.3g} mm over most of the "
            f"wall, as much as its own shape ({1e3 * sizes[0]:.3g} and {1e3 * sizes[1]:.3g} mm rms), which neither "
            "shares with the other",
        )


def _shape(radius: Array, clock: Array) -> Array:
    """(n, m) [m] deviation of every ring from its own circle, to first order."""
    shape = np.full(radius.shape, np.nan)
    for row, (r, c) in enumerate(zip(radius, clock, strict=True)):
        some = np.isfinite(r) & np.isfinite(c)
        if np.count_nonzero(some) > 6:
            design = np.stack([np.ones(some.sum()), np.sin(c[some]), np.cos(c[some])], axis=1)
            shape[row, some] = r[some] - design @ np.linalg.lstsq(design, r[some])[0]
    return shape

"""All quantities of one ring, each with its standard uncertainty, extreme values freed of noise bias.

How the bias of extreme values is removed. (1) The wall is estimated, not the points: a Fourier series whose harmonics
are weighed by evidence at the known noise, plus Gaussian processes on dents, rails and edges. (2) Extremes are taken of
that wall. (3) A parametric bootstrap (fixed seed: same input, same bytes) sends the estimated wall plus noise of the
known covariance through the same smoother; mean minus plug-in value is subtracted. (4) Ovalities end at zero: a
smaller one is reported as zero. The uncertainty is the root mean square distance, from the reported value, of the
quantity over walls that agree with the data, the common modes drawn with each wall as a whole.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.metrics import _definitions as definitions
from calibore.metrics._draws import WallGrid, regular_size, wall_grid
from calibore.metrics._shape import RingShape
from calibore.metrics._sizes import EXTREMES, OVALITIES, corrected_extremes, linear_sizes, second_harmonic
from calibore.metrics._wall import Wall, estimate_wall
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_POINTS = 8
WIDEST_GAP = 1.5 * np.pi  # a quarter of the turn must be seen
FEW_POINTS = 40
LEAST_DIRECTIONS = 0.5
OFF_CENTRE = 0.1  # of the radius
DEFLECTIONS = {"deflection": "min", "deflection_horizontal": "horizontal", "deflection_vertical": "vertical"}
NOTHING = Quantity(np.nan, np.nan)


@dataclass(frozen=True)
class RingQuantities:
    """What a report says of one ring. Lengths [m], area [m^2], ovality and deflection [%], clocks [rad].

    centre: of the fitted circle, rig frame. diameter_mean: mean of D(phi) over the turn, D(phi) = r(phi) + r(phi + pi)
    about the fitted centre; diameter_equivalent_area 2 sqrt(A / pi); diameter_circle: of the fitted circle (features
    left out). diameter_min and diameter_max are extremes of D(phi) over directions with both ends measured; the
    clock of each is pipe clock (clock + roll), one end of the diameter in [0, pi). Area, perimeter, means and the
    second harmonic need the whole turn: a gap is bridged by the smooth series, with the rms of everything beyond an
    ellipse as further uncertainty. Extremes carry what the bridged wall would add to them as further uncertainty.
    deflection: 100 (D0 - D) / D0 where D is smallest, positive where the pipe has shrunk; deflection_clock its clock.

    fraction_measured: of clock positions; fraction_directions: of directions with both ends measured. What cannot be
    measured is NaN. flags: "few-points"; "arc-too-short" (over 270 deg without a point) and "no-circle" (the points go
    round no centre), with which nothing is reported; "gap"; "off-centre" (more than 0.1 R); "extremes-not-measurable"
    (fewer than half of the directions), "horizontal-not-measured", "vertical-not-measured"; "features" (dents, rails,
    edges followed on their own); "lone-points" (left out); "noise-above-stated" (neighbours differ by more than
    u_independent says; it was enlarged); "ovality-not-significant" (ovality_range below its expanded uncertainty;
    where it is zero it was clipped).
    """

    centre_x: Quantity
    centre_y: Quantity
    diameter_mean: Quantity
    diameter_equivalent_area: Quantity
    diameter_circle: Quantity
    diameter_min: Quantity
    diameter_min_clock: Quantity
    diameter_max: Quantity
    diameter_max_clock: Quantity
    diameter_horizontal: Quantity
    diameter_vertical: Quantity
    area: Quantity
    perimeter: Quantity
    ovality_f1216_max: Quantity
    ovality_f1216_min: Quantity
    ovality_range: Quantity
    ovality_harmonic: Quantity
    deflection: Quantity
    deflection_clock: Quantity
    deflection_horizontal: Quantity
    deflection_vertical: Quantity
    points: int
    fraction_measured: float
    fraction_directions: float
    flags: tuple[str, ...]


def ring_quantities(ring: RingShape, *, nominal_radius: float, roll: float = 0.0) -> RingQuantities:
    """The quantities of `ring`; `nominal_radius` [m], `roll` [rad]: pipe clock = clock + roll.

    Ovality as ASTM F1216, as range over mean and from the second harmonic, deflection as AASHTO; see `RingQuantities`
    for each definition, the module for the bias correction. Raises InputError for an impossible nominal radius or roll.
    """
    if not (np.isfinite(nominal_radius) and nominal_radius > 0):
        raise InputError(f"nominal_radius must be a positive length in m, got {nominal_radius:g}.")
    if not np.isfinite(roll):
        raise InputError(f"roll must be a finite angle in rad, got {roll:g}; give 0 where it is not known.")
    count = int(ring.measured.sum())
    if count < LEAST_POINTS:
        return _nothing(ring, "few-points")
    if _widest_gap(ring) > WIDEST_GAP:
        return _nothing(ring, "arc-too-short")
    wall = _wall_or_none(ring)
    if wall is None:
        return _nothing(ring, "no-circle")
    size = regular_size(ring.clock.size)
    axes = np.array([0.5, 1.5, 0.0, 1.0]) * np.pi - roll
    angles = np.concatenate([2 * np.pi * np.arange(size) / size, axes])
    grid = wall_grid(wall, ring, angles=angles, regular=size)
    both = grid.covered[: size // 2] & grid.covered[size // 2 : size]
    flags = _flags(wall, ring, grid, both)
    found = _measurable(
        _in_metres(linear_sizes(grid) | corrected_extremes(grid, both) | second_harmonic(grid), wall.scale), grid, flags
    )
    found |= _clocks(grid, both, found, roll=roll) | _deflections(found, 2 * nominal_radius) | _circle(wall, grid)
    return RingQuantities(
        **found,
        deflection_clock=found["diameter_min_clock"],
        points=int(wall.used.sum()),
        fraction_measured=float(ring.measured.mean()),
        fraction_directions=float(both.mean()),
        flags=tuple(flags),
    )


def _wall_or_none(ring: RingShape) -> Wall | None:
    """The wall, or None where the points do not go round one centre that the rig is inside of."""
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # judged below
            wall = estimate_wall(ring)
    except (InputError, np.linalg.LinAlgError):
        return None
    inside = np.hypot(*wall.centre) < 1 and 0.5 < wall.fit.coefficients[0] < 2
    return wall if inside and np.isfinite(wall.fit.coefficients).all() else None


def _in_metres(found: dict[str, tuple[float, float]], scale: float) -> dict[str, Quantity]:
    powers = {"area": 2} | dict.fromkeys(OVALITIES, 0)
    units = {name: scale ** powers.get(name, 1) for name in found}
    return {name: Quantity(value * units[name], u * units[name]) for name, (value, u) in found.items()}


def _measurable(found: dict[str, Quantity], grid: WallGrid, flags: list[str]) -> dict[str, Quantity]:
    """`found` without what could not be measured; adds the flags that say so."""
    if "extremes-not-measurable" in flags:
        found |= dict.fromkeys(EXTREMES, NOTHING)
    for name, ends in (("horizontal", slice(-4, -2)), ("vertical", slice(-2, None))):
        if not grid.covered[ends].all():
            found[f"diameter_{name}"] = NOTHING
            flags.append(f"{name}-not-measured")
    if found["ovality_range"].value < 2 * found["ovality_range"].u:
        flags.append("ovality-not-significant")
    return found


def _clocks(grid: WallGrid, both: Mask, found: dict[str, Quantity], *, roll: float) -> dict[str, Quantity]:
    ends = {"diameter_min": -1, "diameter_max": 1}
    measurable = np.isfinite(found["diameter_min"].value)
    return {f"{k}_clock": _clock(grid, both, sign, roll=roll) if measurable else NOTHING for k, sign in ends.items()}


def _deflections(found: dict[str, Quantity], nominal_diameter: float) -> dict[str, Quantity]:
    diameters = {name: found[f"diameter_{which}"] for name, which in DEFLECTIONS.items()}
    return {
        name: Quantity(float(definitions.deflection(d.value, nominal_diameter)), 100 * d.u / nominal_diameter)
        for name, d in diameters.items()
    }


def _circle(wall: Wall, grid: WallGrid) -> dict[str, Quantity]:
    """The fitted centre, and the diameter of the circle about it: the zeroth harmonic of the smooth wall."""
    variance = np.maximum(np.diag(wall.fit.covariance), 0.0)  # rounding may leave the least one negative
    common = np.sum(grid.centre_modes**2, axis=0)
    common_radius = np.sum(grid.modes[:, : grid.regular].mean(axis=1) ** 2)
    u_x, u_y, u_radius = wall.scale * np.sqrt(
        [variance[2] + common[0], variance[1] + common[1], variance[0] + common_radius]
    )
    x, y = wall.scale * wall.centre
    return {
        "centre_x": Quantity(float(x), float(u_x)),
        "centre_y": Quantity(float(y), float(u_y)),
        "diameter_circle": Quantity(2 * wall.scale * float(wall.fit.coefficients[0]), 2 * float(u_radius)),
    }


def _clock(grid: WallGrid, both: Mask, sign: int, *, roll: float) -> Quantity:
    """Pipe clock of the largest (sign 1) or smallest (-1) diameter, in [0, pi), and how far it may be off."""
    curve, others = sign * grid.diameters("best")[0], sign * grid.diameters("possible")
    half = curve.size
    place = int(np.argmax(np.where(both, curve, -np.inf)))
    before, here, after = curve[place - 1], curve[place], curve[(place + 1) % half]
    bend = 2 * here - before - after
    peak = place + (0.5 * (after - before) / bend if bend > 0 and max(before, after) <= here else 0.0)
    away = np.mod(np.argmax(np.where(both, others, -np.inf), axis=1) - peak + half / 2, half) - half / 2
    step = np.pi / half
    return Quantity(float(np.mod(peak * step + roll, np.pi)), float(np.sqrt(np.mean(away**2) + 1 / 12) * step))


def _flags(wall: Wall, ring: RingShape, grid: WallGrid, both: Mask) -> list[str]:
    conditions = {
        "few-points": ring.measured.sum() < FEW_POINTS,
        "gap": not grid.covered.all(),
        "off-centre": np.hypot(*wall.centre) > OFF_CENTRE,
        "extremes-not-measurable": both.mean() < LEAST_DIRECTIONS,
        "features": wall.features_mask.any(),
        "lone-points": wall.used.sum() < ring.measured.sum(),
        "noise-above-stated": wall.excess_noise > 1,
    }
    return [name for name, holds in conditions.items() if holds]


def _widest_gap(ring: RingShape) -> float:
    clock = ring.clock[ring.measured]
    return float(np.diff(clock, append=clock[0] + 2 * np.pi).max())


def _nothing(ring: RingShape, flag: str) -> RingQuantities:
    count = int(ring.measured.sum())
    numbers = {field.name: NOTHING for field in fields(RingQuantities) if field.type is Quantity}
    return RingQuantities(
        **numbers,
        points=count,
        fraction_measured=count / ring.clock.size,
        fraction_directions=0.0,
        flags=(flag, "extremes-not-measurable"),
    )

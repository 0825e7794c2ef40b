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

from calibore.errors import InputError
from calibore.kernels import DEFAULT_KERNEL
from calibore.metrics import _definitions as definitions
from calibore.metrics._engine import findings_of
from calibore.metrics._findings import Findings
from calibore.metrics._shape import MOST, RingShape
from calibore.metrics._sizes import EXTREMES, OVALITIES
from calibore.uncertainty import Quantity

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


def ring_quantities(
    ring: RingShape, *, nominal_radius: float, roll: float = 0.0, kernel: str = DEFAULT_KERNEL
) -> RingQuantities:
    """The quantities of `ring`; `nominal_radius` [m], `roll` [rad]: pipe clock = clock + roll.

    Ovality as ASTM F1216, as range over mean and from the second harmonic, deflection as AASHTO; see `RingQuantities`
    for each definition, the module for the bias correction. `kernel` "numpy" runs the twin of the compiled one. Raises
    InputError for an impossible nominal radius or roll.
    """
    if not 1 / MOST <= nominal_radius <= MOST:
        raise InputError(f"nominal_radius must be a positive length in m, got {nominal_radius:g}.")
    if not np.isfinite(roll):
        raise InputError(f"roll must be a finite angle in rad, got {roll:g}; give 0 where it is not known.")
    count = int(ring.measured.sum())
    if count < LEAST_POINTS:
        return _nothing(ring, "few-points")
    if _widest_gap(ring) > WIDEST_GAP:
        return _nothing(ring, "arc-too-short")
    of = findings_of(ring, roll=roll, kernel=kernel)
    if of is None:
        return _nothing(ring, "no-circle")
    flags = _flags(of, count)
    found = _measurable(_in_metres(of.wall, of.scale), of, flags)
    found |= _clocks(of, found, roll=roll) | _deflections(found, 2 * nominal_radius) | _circle(of)
    return RingQuantities(
        **found,
        deflection_clock=found["diameter_min_clock"],
        points=of.points,
        fraction_measured=count / ring.clock.size,
        fraction_directions=of.directions,
        flags=tuple(flags),
    )


def _in_metres(found: dict[str, tuple[float, float]], scale: float) -> dict[str, Quantity]:
    powers = {"area": 2} | dict.fromkeys(OVALITIES, 0)
    units = {name: scale ** powers.get(name, 1) for name in found}
    return {name: Quantity(value * units[name], u * units[name]) for name, (value, u) in found.items()}


def _measurable(found: dict[str, Quantity], of: Findings, flags: list[str]) -> dict[str, Quantity]:
    """`found` without what could not be measured; adds the flags that say so."""
    if "extremes-not-measurable" in flags:
        found |= dict.fromkeys(EXTREMES, NOTHING)
    for name, seen in (("horizontal", of.horizontal), ("vertical", of.vertical)):
        if not seen:
            found[f"diameter_{name}"] = NOTHING
            flags.append(f"{name}-not-measured")
    if found["ovality_range"].value < 2 * found["ovality_range"].u:
        flags.append("ovality-not-significant")
    return found


def _clocks(of: Findings, found: dict[str, Quantity], *, roll: float) -> dict[str, Quantity]:
    measurable = np.isfinite(found["diameter_min"].value)
    return {
        name: Quantity(float(np.mod(value + roll, np.pi)), u) if measurable else NOTHING
        for name, (value, u) in of.clocks.items()
    }


def _deflections(found: dict[str, Quantity], nominal_diameter: float) -> dict[str, Quantity]:
    diameters = {name: found[f"diameter_{which}"] for name, which in DEFLECTIONS.items()}
    return {
        name: Quantity(float(definitions.deflection(d.value, nominal_diameter)), 100 * d.u / nominal_diameter)
        for name, d in diameters.items()
    }


def _circle(of: Findings) -> dict[str, Quantity]:
    """The fitted centre, and the diameter of the circle about it: the zeroth harmonic of the smooth wall."""
    (x, u_x), (y, u_y), (radius, u_radius) = of.circle
    return {
        "centre_x": Quantity(of.scale * x, of.scale * u_x),
        "centre_y": Quantity(of.scale * y, of.scale * u_y),
        "diameter_circle": Quantity(2 * of.scale * radius, 2 * of.scale * u_radius),
    }


def _flags(of: Findings, measured: int) -> list[str]:
    conditions = {
        "few-points": measured < FEW_POINTS,
        "gap": of.gap,
        "off-centre": np.hypot(of.circle[0][0], of.circle[1][0]) > OFF_CENTRE,
        "extremes-not-measurable": of.directions < LEAST_DIRECTIONS,
        "features": of.features,
        "lone-points": of.points < measured,
        "noise-above-stated": of.excess_noise > 1,
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

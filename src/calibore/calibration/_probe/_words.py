"""What the calibration of a probe tells people."""

from collections.abc import Iterator

import numpy as np

from calibore.calibration._in_words import Unit
from calibore.calibration._probe._diameters import DOUBTFUL, Intercept
from calibore.calibration._probe._line import Line
from calibore.calibration._probe._tables import ProbeTables
from calibore.rigs import Probe

NOT_CHANCE = 0.01
"""Trends that chance gives less often than this are told as such."""


def findings(tables: ProbeTables, line: Line, intercept: Intercept, probe: Probe) -> Iterator[str]:
    """The conversion and its uncertainty first, then what it rests on."""
    unit = tables.unit
    u_slope, u_intercept = probe.covariance.u
    ratio = intercept.mean_ratio
    yield (
        f"Radius = {unit.said(probe.slope, u_slope)} x ratio + {unit.said(probe.intercept, u_intercept)} (u = "
        f"{unit.said(u_slope, u_slope)} and {unit.said(u_intercept, u_intercept)}); use it for readings of this probe "
        "on this bracket."
    )
    yield (
        f"At a radius of {unit.said(float(probe.radius(ratio)), 0.1 * unit.size)}, where the diameters were measured, "
        f"the conversion is uncertain by {_small(float(probe.u_common(ratio)), unit)} (k = 1, alike for all points); "
        f"one reading adds {_small(probe.noise, unit)} of its own."
    )
    yield _shares(tables, intercept, probe)
    yield from _straightness(line, unit)
    kept = int(intercept.kept.sum())
    yield (
        f"The intercept is the mean of {kept} of {intercept.kept.size} diameters, b = [diameter - slope (raw 1 + raw "
        f"2)] / 2; they scatter by {_small(float(np.ptp(intercept.each[intercept.kept])), unit)} from least to most."
    )


def _shares(tables: ProbeTables, intercept: Intercept, probe: Probe) -> str:
    """The budget of the radius at the diameters, in per cent of the variance."""
    target = tables.target
    parts = {
        "contact of tip and caliper with the wall": 2 * target.u_contact**2,
        "reading the voltages": 2 * probe.noise**2,
        "reading the caliper": target.u_caliper**2,
    }
    total = sum(parts.values()) or 1.0
    said = ", ".join(
        f"{100 * part / total:.0f} % {name}" for name, part in sorted(parts.items(), key=lambda item: -item[1])
    )
    return (
        f"Of the variance of the intercept at the diameters' own ratio: {said}. The slope adds "
        f"{_small(float(probe.covariance.u[0]), tables.unit)} per unit of ratio away from {intercept.mean_ratio:.3f}."
    )


def _straightness(line: Line, unit: Unit) -> Iterator[str]:
    if line.p_curved >= NOT_CHANCE:
        yield (
            f"Length against ratio is straight as far as its scatter of {_small(line.scatter, unit)} tells "
            f"(p = {line.p_curved:.2f})."
        )
    if line.p_drift is None:
        yield (
            "The lengths were set in order, so a drift of the bias voltage would look like slope; repeat some of the "
            "first lengths at the end to tell them apart."
        )
    elif line.p_drift >= NOT_CHANCE:
        yield f"Nothing drifted while the lengths were measured (p = {line.p_drift:.2f})."


def warnings(tables: ProbeTables, line: Line, intercept: Intercept) -> Iterator[str]:
    """Diameters left out or at odds, curvature, drift, correlated neighbours, a caliper better than stated."""
    unit = tables.unit
    for index in np.flatnonzero(~intercept.kept):
        first, second = tables.stops[index]
        off = float(intercept.each[index] - intercept.value)
        yield (
            f"Diameter {index + 1} (stops {first} and {second}, "
            f"{unit.said(float(tables.diameter[index]), 0.01 * unit.size)}) was left out: its intercept is "
            f"{unit.said(off, float(intercept.u_each[index]), sign=True)} off the others, "
            f"{abs(intercept.deviation[index]):.0f} standard uncertainties. Probably not the tip touched there, or a "
            "feature's flank; measure diameters on plain wall."
        )
    if intercept.enlarged > 1:
        yield (
            f"The diameters disagree by more than their uncertainty (by chance less often than {100 * DOUBTFUL:g} %); "
            f"it was enlarged {intercept.enlarged:.1f} times. Measure more diameters, on plain wall."
        )
    if intercept.kept.sum() == 1:
        yield "The intercept rests on one diameter, which nothing checks; measure at least three."
    elif intercept.kept.size == 2:
        yield "Two diameters cannot tell which of them is wrong; measure at least three."
    yield from _line_warnings(tables, line)


def _line_warnings(tables: ProbeTables, line: Line) -> Iterator[str]:
    unit = tables.unit
    if line.p_curved < NOT_CHANCE:
        yield (
            f"Length against ratio is not straight (p = {line.p_curved:.1g}): a cubic differs from the line by up to "
            f"{_small(line.bow, unit)}. Check the cylinder's potentiometer, or calibrate over the part of the stroke "
            "in use."
        )
    if line.p_drift is not None and line.p_drift < NOT_CHANCE:
        yield (
            f"The readings drifted by {_small(line.drift, unit)} during the calibration (p = {line.p_drift:.1g}); "
            "measure the bias voltage with every signal."
        )
    if line.stretch > 1:
        yield (
            f"Neighbouring lengths are off alike (p = {line.p_alike:.1g}); the uncertainty of the slope was enlarged "
            f"{np.sqrt(line.stretch):.1f} times."
        )
    if line.scatter < tables.target.u_caliper / 2:
        yield (
            f"The lengths scatter by {_small(line.scatter, unit)} only, less than the caliper's stated "
            f"{_small(tables.target.u_caliper, unit)}; state u_caliper as it is."
        )


def _small(metres: float, unit: Unit) -> str:
    """With two significant digits."""
    return unit.said(metres, abs(metres))

"""What the page of a comparison says in numbers and words: the answer first."""

from math import floor, log10

import numpy as np

from calibore.comparison import Compared, Region, per_year
from calibore.plotting import clock_text, length_unit, plain_text
from calibore.uncertainty import Quantity

Fact = dict[str, str]
EXPECTED = (0.90, 0.99)
"""Fractions inside 95 % intervals that one comparison, with its common errors, may well show."""
ON = 0.95
"""Of the compared wall, for which a level of detection is stated."""
ANGLES, FACTORS = ("roll", "tilt_x", "tilt_y"), ("stretch", "scale")


def answer(found: Compared, unit: str) -> list[str]:
    """Sentences, the most important first."""
    return _change_answer(found, unit) if found.changes is not None else _error_answer(found, unit)


def _error_answer(found: Compared, unit: str) -> list[str]:
    overall, plain, size = found.agreement.overall, found.away_from_edges(), length_unit(unit).metres
    rule = found.agreement.rule.said(lambda limit: f"{limit / size:.4g} {unit}")
    first = (
        f"{found.names[0]} against {found.names[1]}: rms error {plain_text(overall.rms / size, 3)} {unit}, predicted "
        f"{plain_text(overall.predicted / size, 3)} {unit}; {100 * overall.inside:.1f} % of {overall.points} points "
        "lie inside their 95 % intervals."
    )
    away = (
        f"Edges left out ({plain.points} points): rms {plain_text(plain.rms / size, 3)} {unit}, predicted "
        f"{plain_text(plain.predicted / size, 3)} {unit}."
    )
    return [first, away, _verdict(overall.inside), f"{overall.outliers} outliers ({rule}), not in the rms."]


def _verdict(inside: float) -> str:
    low, high = EXPECTED
    if inside < low:
        return (
            "The errors are larger than stated: the uncertainty of one of the two is too small, or a calibration has "
            "drifted. Look at the error against the radius."
        )
    if inside > high:
        return (
            "The errors are smaller than stated; part of the uncertainty is common to all points, and happened to be "
            "small this time, or too much is stated."
        )
    return "The errors are as large as stated."


def _change_answer(found: Compared, unit: str) -> list[str]:
    change, size = found.changes, length_unit(unit).metres
    assert change is not None
    count = len(change.regions)
    sentences = []
    if count:
        where = "one place" if count == 1 else f"{count} places"
        sentences.append(f"The wall has changed at {where}: {_region_words(change.regions[0], unit, found.years)}")
        sentences += [f"Also: {_region_words(one, unit, found.years)}" for one in change.regions[1:3]]
    else:
        sentences.append("No significant change of the wall.")
    least = change.level_of_detection[np.isfinite(change.level_of_detection)]
    if least.size:
        words = "Elsewhere no" if count else "No"
        wide = 31 * 2 * np.pi / found.moving.clock.size * found.reference.typical_radius
        sentences.append(
            f"{words} change larger than {plain_text(float(np.quantile(least, ON)) / size, 2)} {unit} (median "
            f"of the wall {plain_text(float(np.median(least)) / size, 2)} {unit}) over a patch up to "
            f"{plain_text(float(wide) / size, 2)} {unit} wide would have escaped, with 95 % probability, on "
            f"{100 * ON:.0f} % of the compared wall."
        )
    sentences.append(f"An unchanged pipe would show any region with a probability of {100 * change.false_alarm:g} %.")
    return sentences


def _region_words(region: Region, unit: str, years: float | None) -> str:
    size = length_unit(unit).metres
    inwards = "less" if region.depth.value < 0 else "more"
    rate = ""
    if years is not None:
        rate = f", {with_u(_scaled(per_year(region.depth, years), 1 / size))} {unit} per year"
    degrees = _scaled(region.clock, float(180 / np.pi))
    return (
        f"radius {with_u(_scaled(region.depth, 1 / size))} {unit} ({inwards} than before) at axial "
        f"{with_u(_scaled(region.axial, 1 / size))} {unit}, clock {with_u(degrees)} deg "
        f"({clock_text(region.clock.value)}){rate}."
    )


def facts(found: Compared, unit: str) -> list[Fact]:
    """The numbers on top of the page."""
    overall, size, agreed = found.agreement.overall, length_unit(unit).metres, found.agreement
    said: list[Fact] = []
    if found.changes is None:
        said += [
            {"name": "rms error", "value": f"{plain_text(overall.rms / size, 3)} {unit}",
             "remark": f"predicted {plain_text(overall.predicted / size, 3)} {unit}"},
            {"name": "inside 95 % intervals", "value": f"{100 * overall.inside:.1f} %", "remark": "95 % expected"},
            {"name": "mean error", "value": f"{plain_text(overall.mean / size, 2, sign=True)} {unit}", "remark": ""},
        ]  # fmt: skip
    else:
        least = found.changes.level_of_detection
        some = least[np.isfinite(least)]
        said += [
            {"name": "places of change", "value": str(len(found.changes.regions)),
             "remark": f"false alarm {100 * found.changes.false_alarm:g} %"},
            {"name": "level of detection", "value": f"{plain_text(float(np.median(some)) / size, 2)} {unit}"
             if some.size else "none", "remark": "median of the wall, 95 % probability"},
        ]  # fmt: skip
    scatter = found.registration.scatter
    said += [
        {"name": "points compared", "value": str(overall.points),
         "remark": f"of {int(found.moving.measured.sum())} of {found.names[0]}; "
         f"{agreed.degrees_of_freedom:.0f} degrees of freedom"},
        {"name": "scatter over what is stated", "value": plain_text(scatter, 2), "remark": "robust, registered"},
    ]  # fmt: skip
    return said


def motion_rows(found: Compared, unit: str) -> list[Fact]:
    """The motion, what was free with its uncertainty."""
    registration, size, rows = found.registration, length_unit(unit).metres, []
    for name, value in zip(registration.motion.names, registration.motion.values.tolist(), strict=True):
        factor, symbol = (
            (180 / np.pi, "deg") if name in ANGLES else (1.0, "") if name in FACTORS else (1 / size, unit)
        )  # fmt: skip
        free, one = name in registration.names, Quantity(value * factor, registration.u(name) * factor)
        digits = _digits(one.u)
        rows.append({
            "name": name.replace("_", " "), "value": f"{one.value:.{digits}f}", "unit": symbol,
            "u": f"{one.u:.{digits}f}" if free else "held",
            "remark": "not told by the profiles" if name in registration.untold else "",
        })  # fmt: skip
    return rows


def region_rows(found: Compared, unit: str) -> list[Fact]:
    """A row for every region of change."""
    size, rows = length_unit(unit).metres, []
    for number, one in enumerate(found.changes.regions if found.changes else (), start=1):
        rows.append({
            "number": str(number),
            "axial": with_u(_scaled(one.axial, 1 / size)),
            "clock": with_u(_scaled(one.clock, float(180 / np.pi))),
            "area": plain_text(one.area / size**2, 3),
            "depth": with_u(_scaled(one.depth, 1 / size)),
            "mean": with_u(_scaled(one.mean, 1 / size)),
            "volume": with_u(_scaled(one.volume, size**-3)),
            "rate": "" if found.years is None else with_u(_scaled(per_year(one.depth, found.years), 1 / size)),
        })  # fmt: skip
    return rows


def radius_rows(found: Compared, unit: str) -> list[Fact]:
    """Errors by radius, as in Table 8.4."""
    size = length_unit(unit).metres
    return [
        {
            "radius": f"{one.place / size:.{3 if unit == 'in' else 1}f}",
            "points": str(one.points),
            "rms": plain_text(one.rms / size, 3),
            "mean": plain_text(one.mean / size, 2, sign=True),
            "predicted": plain_text(one.predicted / size, 3),
            "inside": f"{100 * one.inside:.1f} %",
        }
        for one in found.agreement.by_radius
    ]


def with_u(one: Quantity) -> str:
    """-1.30 ± 0.19"""
    digits = _digits(one.u)
    return f"{one.value:.{digits}f} ± {one.u:.{digits}f}"


def _scaled(one: Quantity, factor: float) -> Quantity:
    return Quantity(one.value * factor, one.u * factor)


def _digits(u: float) -> int:
    return min(max(0, 1 - floor(log10(u))), 9) if 0 < u < np.inf else 4

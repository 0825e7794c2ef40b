"""What the rings say: key numbers, places, limits and the table of worst stations, as text ready for the page."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.plotting import COVERAGE_FACTOR, axial_unit, clock_text, governing_ovality, length_unit, worst_stations
from calibore.reports._numbers import NOT_MEASURED, expanded_text, percent_text
from calibore.reports._words import FLAG_MEANINGS

WORST_COUNT = 10
Rings = Mapping[str, Any]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class KeyNumber:
    """One number of the head of the page: `name`, `value` with U95, and a `remark` that says where or how."""

    name: str
    value: str
    remark: str


@dataclass(frozen=True)
class LimitCheck:
    """A limit and how many stations are within it, above it, or cannot be decided at 95 %."""

    name: str
    limit: str
    within: int
    above: int
    undecided: int
    unknown: int


def key_numbers(rings: Rings, summary: Mapping[str, Any], *, unit: str) -> list[KeyNumber]:
    """Mean diameter, worst ovality, worst deflection and share measured."""
    ovality, u_ovality = governing_ovality(rings)
    deflection, u_deflection = (numbers(rings, name) for name in ("deflection_percent", "u_deflection_percent"))
    worst, most = largest(ovality), largest(deflection)
    clock = numbers(rings, "deflection_clock_rad")
    return [
        _mean_diameter(rings, summary, unit),
        KeyNumber("Worst ovality", _at(ovality, u_ovality, worst, "%"), place(rings, worst, unit)),
        KeyNumber(
            "Worst deflection",
            _at(deflection, u_deflection, most, "%"),
            place(rings, most, unit, clock=np.nan if most is None else clock[most]),
        ),
        KeyNumber("Measured", percent_text(_mean(numbers(rings, "fraction"))), f"of all points at {_stations(rings)}"),
    ]


def _mean_diameter(rings: Rings, summary: Mapping[str, Any], unit: str) -> KeyNumber:
    scale = length_unit(unit)
    remark = f"over {_stations(rings)}"
    if "mean_diameter_m" in summary and "u_mean_diameter_m" in summary:
        value, u = float(summary["mean_diameter_m"]), float(summary["u_mean_diameter_m"])
    else:
        # Without the modes at hand: all of u taken as common to the stations, the largest their mean can have.
        value, u = _mean(numbers(rings, "diameter_mean_m")), _mean(numbers(rings, "u_diameter_mean_m"))
        remark += "; U95 as if shared by all of them (upper bound)"
    return KeyNumber("Mean diameter", expanded_text(value / scale.metres, u / scale.metres, unit), remark)


def limit_checks(rings: Rings, limits: Mapping[str, float]) -> list[LimitCheck]:
    """Every ring against "ovality_percent" and "deflection_percent" in `limits`, U95 taken into account."""
    ovality = governing_ovality(rings)
    deflection = numbers(rings, "deflection_percent"), numbers(rings, "u_deflection_percent")
    kinds = (("Ovality", "ovality_percent", ovality), ("Deflection", "deflection_percent", deflection))
    return [_check(name, float(limits[key]), *found) for name, key, found in kinds if limits.get(key) is not None]


def _check(name: str, limit: float, value: Floats, u: Floats) -> LimitCheck:
    known = np.isfinite(value) & np.isfinite(u)
    margin = COVERAGE_FACTOR * u
    with np.errstate(invalid="ignore"):
        above, within = known & (value - margin > limit), known & (value + margin <= limit)
    undecided = known & ~above & ~within
    counts = (int(mask.sum()) for mask in (within, above, undecided, ~known))
    return LimitCheck(name, f"{limit:g} %", *counts)


def worst_table(rings: Rings, *, unit: str, nominal_radius: float, count: int = WORST_COUNT) -> list[dict[str, str]]:
    """The `count` worst stations by ovality, a row of texts each, places a diameter apart if the pipe allows."""
    rows = worst_stations(rings, count=count, apart=2 * nominal_radius)
    return [_row(rings, row, unit) for row in rows]


def _row(rings: Rings, row: int, unit: str) -> dict[str, str]:
    scale, along = length_unit(unit), axial_unit(unit, span(rings))
    ovality, u_ovality = governing_ovality(rings)

    def lengths(name: str) -> str:
        value, u = numbers(rings, name)[row], numbers(rings, f"u_{name}")[row]
        return expanded_text(value / scale.metres, u / scale.metres)

    deflection, u_deflection = numbers(rings, "deflection_percent")[row], numbers(rings, "u_deflection_percent")[row]
    clock = numbers(rings, "deflection_clock_rad")[row]
    return {
        "station": str(rings["station"][row]),
        "axial": f"{numbers(rings, 'axial_m')[row] / along.metres:.5g}",
        "ovality": expanded_text(ovality[row], u_ovality[row]),
        "deflection": expanded_text(deflection, u_deflection),
        "clock": clock_text(clock) if np.isfinite(clock) else "",
        "mean": lengths("diameter_mean_m"),
        "smallest": lengths("diameter_min_m"),
        "largest": lengths("diameter_max_m"),
        "measured": percent_text(numbers(rings, "fraction")[row]),
        "flags": ", ".join(flags_of(rings, row)),
    }


def flags_of(rings: Rings, row: int) -> list[str]:
    """Names of the flags of one ring."""
    text = str(rings["flags"][row]) if "flags" in rings else ""
    return [flag for flag in re.split(r"[\s,;|]+", text) if flag and flag != "nan"]


def flag_counts(rings: Rings) -> list[tuple[str, str, int]]:
    """Every flag that occurs with its meaning and the number of its stations, the most frequent first."""
    found: dict[str, int] = {}
    for row in range(len(rings["station"])):
        for flag in flags_of(rings, row):
            found[flag] = found.get(flag, 0) + 1
    ranked = sorted(found.items(), key=lambda item: (-item[1], item[0]))
    return [(flag, FLAG_MEANINGS.get(flag, ""), count) for flag, count in ranked]


def numbers(rings: Rings, name: str) -> Floats:
    """Column `name` (n,) as float; NaN throughout where the table lacks it."""
    return np.asarray(rings[name], float) if name in rings else np.full(len(rings["station"]), np.nan)


def largest(values: Floats) -> int | None:
    """Row of the largest value; None where there is none."""
    return int(np.nanargmax(values)) if np.isfinite(values).any() else None


def place(rings: Rings, row: int | None, unit: str, *, clock: float = np.nan) -> str:
    """Where a ring is: "station 12, axial 1.32 m", with the `clock` position if there is one."""
    if row is None:
        return "at no station"
    along = axial_unit(unit, span(rings))
    axial = numbers(rings, "axial_m")[row] / along.metres
    hour = f", {clock_text(clock)}" if np.isfinite(clock) else ""
    return f"station {rings['station'][row]}, axial {axial:.5g} {along.symbol}{hour}".replace(
        " h", "\N{NO-BREAK SPACE}h"
    )


def span(rings: Rings) -> float:
    """Length [m] from the first to the last station."""
    axial = numbers(rings, "axial_m")
    axial = axial[np.isfinite(axial)]
    return float(np.ptp(axial)) if axial.size else 0.0


def _at(values: Floats, u: Floats, row: int | None, unit: str) -> str:
    return NOT_MEASURED if row is None else expanded_text(values[row], u[row], unit)


def _mean(values: Floats) -> float:
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")


def _stations(rings: Rings) -> str:
    count = len(rings["station"])
    return f"{count} station{'s' * int(count != 1)}"

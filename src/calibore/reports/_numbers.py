"""Numbers as a report prints them: rounded to the uncertainty they carry (JCGM 100, 7.2.6)."""

import math

from calibore.plotting import COVERAGE_FACTOR

SIGNIFICANT = 2
"""Digits of an expanded uncertainty that are printed."""

MOST_DECIMALS = 6
NOT_MEASURED = "not measured"


def expanded_text(value: float, u: float, unit: str = "") -> str:
    """`value` with the expanded uncertainty (k = 2) of standard uncertainty `u`, both in `unit`.

    NaN `value` reads "not measured"; NaN `u` says that the uncertainty is not known.
    """
    tail = f" {unit}" if unit else ""
    if not math.isfinite(value):
        return NOT_MEASURED
    if not math.isfinite(u):
        return f"{value:.4g}{tail} (uncertainty not known)"
    expanded = COVERAGE_FACTOR * u
    digits = decimals(expanded)
    return (
        f"({value:.{digits}f} ± {expanded:.{digits}f}){tail}" if unit else f"{value:.{digits}f} ± {expanded:.{digits}f}"
    )


def decimals(expanded: float) -> int:
    """Decimals that show `expanded` with two significant digits; 3 for zero."""
    if not expanded > 0:
        return 3
    return min(MOST_DECIMALS, max(0, SIGNIFICANT - 1 - math.floor(math.log10(expanded))))


def percent_text(fraction: float) -> str:
    """`0.9731` -> "97.3 %"; never "100.0 %" unless all of it."""
    if not math.isfinite(fraction):
        return NOT_MEASURED
    shown = min(fraction * 100, 99.9) if fraction < 1 else 100.0
    return f"{shown:.1f} %"

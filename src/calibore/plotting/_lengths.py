"""Units of length on pictures: metres come in, the reader's unit goes out."""

from dataclasses import dataclass
from math import floor, isfinite, log10

from calibore.errors import InputError


@dataclass(frozen=True)
class LengthUnit:
    """A unit of length with its size in metres."""

    symbol: str
    metres: float

    def __post_init__(self) -> None:
        if not self.metres > 0:
            raise InputError(f'Unit "{self.symbol}" must be larger than zero metres, got {self.metres}.')


UNITS = {unit.symbol: unit for unit in (LengthUnit("mm", 1e-3), LengthUnit("in", 0.0254))}
LONG_UNITS = {"mm": LengthUnit("m", 1.0), "in": LengthUnit("ft", 0.3048)}
LONG_SPAN = 5.0
"""Metres along the pipe from which on axes read in m (or ft)."""
ROUNDING = 1e-9
"""Values that are no more are what is left of rounding."""


def length_unit(symbol: str) -> LengthUnit:
    """The unit called `symbol`, "mm" or "in"; raises InputError for any other."""
    if symbol not in UNITS:
        raise InputError(f'Unit "{symbol}" is not known for pictures; use "mm" or "in".')
    return UNITS[symbol]


def axial_unit(symbol: str, span: float) -> LengthUnit:
    """The unit for positions along a pipe of length `span` [m]: mm or m, in or ft."""
    short = length_unit(symbol)
    return LONG_UNITS[symbol] if span >= LONG_SPAN else short


def checked_radius(nominal_radius: float) -> float:
    """`nominal_radius` [m] if it can be a radius, else InputError."""
    if not 0 < nominal_radius < float("inf"):
        raise InputError(f"The nominal radius must be positive, got {nominal_radius} m; give it in metres.")
    return float(nominal_radius)


def plain_text(value: float, digits: int = 3, *, sign: bool = False) -> str:
    """`value` with so many significant digits and without an exponent; 0 where it is rounding."""
    if abs(value) < ROUNDING:
        return "0"
    decimals = max(0, digits - 1 - floor(log10(abs(value)))) if isfinite(value) else 0
    rounded = round(value, digits - 1 - floor(log10(abs(value)))) if isfinite(value) else value
    return f"{rounded:{'+' if sign else ''}.{decimals}f}"

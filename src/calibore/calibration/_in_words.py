"""Values with their uncertainty as people write them."""

from dataclasses import dataclass
from math import floor, isfinite, log10
from typing import Self

import numpy as np

from calibore.units import parse_quantity

LENGTHS = ("baseline", "offset", "x", "y", "z")
ANGLES = ("aim", "half_angle", "clock", "zenith")
WORDS = {"k": "k", "principal_point_u": "principal point u", "principal_point_v": "principal point v"}
PIXELS = ("k", "principal_point_u", "principal_point_v")
NOTHING = 1e-6
"""Values that are no more, in the unit of whoever reads them, are nothing to people."""
IMPROBABLE = 0.001
"""Probabilities below are all the same to people."""


@dataclass(frozen=True)
class Unit:
    """`symbol`, and what one of it is in SI; "" a pure number."""

    symbol: str
    size: float = 1.0

    @classmethod
    def of_length(cls, text: str) -> Self:
        """The unit in which somebody wrote the length `text`."""
        symbol = text.strip().lstrip("+-0123456789.eE").strip()
        return cls(symbol, parse_quantity(f"1 {symbol}", "length"))

    def said(self, value: float, u: float = 0.0, *, sign: bool = False) -> str:
        """`value` [SI] with as many digits as its standard uncertainty `u` [SI] allows, two of which it shows."""
        value, u = value / self.size, u / self.size
        digits = max(0, 1 - int(np.floor(np.log10(u)))) if u > 0 else 4
        text = f"{value:+.{digits}f}" if sign else f"{value:.{digits}f}"
        return f"{text} {self.symbol}".rstrip()

    def roughly(self, value: float, digits: int = 2, *, sign: bool = False) -> str:
        """`value` [SI] with so many significant digits."""
        return f"{plain_number(value / self.size, digits, sign=sign)} {self.symbol}".rstrip()


DEGREE, PIXEL, NUMBER = Unit("deg", np.pi / 180), Unit("px"), Unit("")


def unit_of(name: str, length: Unit) -> Unit:
    """The unit people use for the parameter with this dotted path; `length`: theirs for lengths."""
    key = name.split(".")[-1]
    return length if key in LENGTHS else DEGREE if key in ANGLES else PIXEL if key in PIXELS else NUMBER


def plain_number(value: float, digits: int = 2, *, sign: bool = False) -> str:
    """`value` with so many significant digits and no exponent; 0 where it is nothing."""
    if abs(value) < NOTHING:
        return "0"
    if not isfinite(value):
        return f"{value:{'+' if sign else ''}}"
    places = digits - 1 - floor(log10(abs(value)))
    return f"{round(value, places):{'+' if sign else ''}.{max(0, places)}f}"


def probability(p: float) -> str:
    """As in `"p = 0.23"` or `"p < 0.001"`."""
    return f"p = {plain_number(p)}" if p >= IMPROBABLE else f"p < {IMPROBABLE}"


def word_of(name: str) -> str:
    """`"laser.0.half_angle"` -> `"half angle of laser 0"`."""
    table, *rest = name.split(".")
    key = rest[-1]
    word = WORDS.get(key, key.replace("_", " "))
    return f"{word} of laser {rest[0]}" if table == "laser" and len(rest) > 1 else word

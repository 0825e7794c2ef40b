"""Quantities with units at the edge: `"13.10 in"` becomes 0.33274 m; inside the program everything is SI."""

import re
from functools import cache, lru_cache
from math import inf
from typing import Any

from calibore.errors import InputError

DIMENSIONS = {
    "length": ("m", 'a length such as "150 mm" or "6 in"'),
    "angle": ("rad", 'an angle such as "1.5 deg" or "26 mrad"'),
    "time": ("s", 'a time such as "0.2 s"'),
}

_NUMBER_AND_UNIT = re.compile(
    r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]+)?|[-+]?(?:nan|inf))\s*([^\W\d_]*|°)", flags=re.IGNORECASE
)
"""Left to pint, "1,5 mm" would be 15 mm, "1 1/2 in" half an inch, and "9**9**9 m" computed for ever."""

USUAL = {
    "length": {"m": 1.0, "mm": 0.001, "cm": 0.01, "um": 1e-6, "in": 0.0254, "ft": 0.30479999999999996},
    "angle": {"rad": 1.0, "mrad": 0.001, "deg": 0.017453292519943295},
    "time": {"s": 1.0, "ms": 0.001},
}
"""What pint multiplies by, rounding included: to be imported and to read its units takes it half a second."""


LARGEST = {"length": 1e6, "angle": 1e6, "time": 1e9}
"""m, rad, s; more is a mistake, and the squares of what is less are still numbers."""


@cache
def _registry() -> Any:
    import pint  # 0.16 s: only when a quantity is really parsed

    registry = pint.UnitRegistry()
    registry.formatter.default_format = "~"
    return registry


@lru_cache(maxsize=256)
def parse_quantity(text: str, dimension: str) -> float:
    """The SI value of `text`, a number with a unit of the given `dimension` ("length", "angle", "time").

    Raises InputError naming the text and what is expected.
    """
    unit, example = DIMENSIONS[dimension]
    written = _NUMBER_AND_UNIT.fullmatch(text.strip())
    if written is None:
        raise InputError(f'"{text}" is not {example} (one number with a decimal point, and its unit).')
    number, symbol = written.groups()
    if not symbol:
        raise InputError(f'"{text}" has no unit; write {example}.')
    if symbol in USUAL[dimension]:
        return _bounded(text, float(number) * USUAL[dimension][symbol], dimension)
    try:
        value = float(_registry().Quantity(float(number), symbol).to(unit).magnitude)
    except Exception as error:  # pint raises half a dozen unrelated types on what it does not know
        raise InputError(f'"{text}" is not {example}.') from error
    return _bounded(text, value, dimension)


def _bounded(text: str, value: float, dimension: str) -> float:
    if LARGEST[dimension] < abs(value) < inf:
        unit, _ = DIMENSIONS[dimension]
        raise InputError(
            f'"{text}" is beyond any {dimension} here, {LARGEST[dimension]:.0f} {unit}; correct the number or its unit.'
        )
    return value

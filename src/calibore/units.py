"""Quantities with units at the edge: `"13.10 in"` becomes 0.33274 m; inside the program everything is SI."""

import re
from functools import cache, lru_cache
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
    try:
        return float(_registry().Quantity(float(number), symbol).to(unit).magnitude)
    except Exception as error:  # pint raises half a dozen unrelated types on what it does not know
        raise InputError(f'"{text}" is not {example}.') from error

"""Quantities with units at the edge: `"13.10 in"` becomes 0.33274 m; inside the program everything is SI."""

from functools import cache, lru_cache
from typing import Any

from calibore.errors import InputError

DIMENSIONS = {
    "length": ("m", "a length such as \"150 mm\" or \"6 in\""),
    "angle": ("rad", "an angle such as \"1.5 deg\" or \"26 mrad\""),
    "time": ("s", "a time such as \"0.2 s\""),
}


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
    try:
        quantity = _registry().Quantity(text.strip())
        if not quantity.unitless:
            return float(quantity.to(unit).magnitude)
    except Exception as error:  # pint raises half a dozen unrelated types, and tokenize errors, on bad text
        raise InputError(f'"{text}" is not {example}.') from error
    raise InputError(f'"{text}" has no unit; write {example}.')


def format_length(metres: float, unit: str = "mm", *, digits: int = 3) -> str:
    """`0.1524` -> `"152.400 mm"`."""
    return f"{metres / parse_quantity(f'1 {unit}', 'length'):.{digits}f} {unit}"

"""target.toml from what a simulated laboratory says of its target."""

import json
from collections.abc import Iterator, Mapping
from typing import Any


def metres(value: float) -> str:
    """Twelve digits: no length is known better, and 6 in stays 0.1524 m."""
    return f"{value:.12g} m"


def radians(value: float) -> str:
    return f"{value:.12g} rad"


def toml_text(said: Mapping[str, Any]) -> str:
    """`said` as TOML: numbers, text, lists of these; lists of mappings become tables at the end; None is left out."""
    return "\n".join(_lines({key: value for key, value in said.items() if value is not None})) + "\n"


def _lines(said: Mapping[str, Any]) -> Iterator[str]:
    tables = {key: value for key, value in said.items() if _is_tables(value)}
    yield from (f"{key} = {_value(value)}" for key, value in said.items() if key not in tables)
    for key, rows in tables.items():
        for row in rows:
            yield from ("", f"[[{key}]]", *_lines(row))


def _is_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False)

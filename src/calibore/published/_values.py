"""The numbers that the dissertation prints, as facts: where, what, how many digits, and what each is computed from."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from importlib.resources import files
from typing import Any

from calibore.errors import InputError


@dataclass(frozen=True)
class PublishedValue:
    """`printed` digits of a number, None where the source states none; `quantity` names the function that computes it
    anew from `inputs`. `tolerance`, in `unit`: what its wording or printing can carry. `scanned`: the digits that the
    damaged scan shows; `contradiction`: what in the source speaks against itself.
    """

    id: str
    where: str
    what: str
    tolerance: float
    unit: str
    quantity: str
    inputs: Mapping[str, float]
    printed: str | None = None
    note: str = ""
    scanned: str | None = None
    contradiction: str | None = None
    half_digit: float = field(init=False)

    def __post_init__(self) -> None:
        if not self.tolerance > 0:
            raise InputError(f"The tolerance of {self.id} must be positive, got {self.tolerance}; state it.")
        exponent = Decimal(self.printed or "0").as_tuple().exponent
        object.__setattr__(self, "half_digit", 0.5 * 10.0 ** int(exponent))

    @property
    def published(self) -> float | None:
        return None if self.printed is None else float(self.printed)


@cache
def published_values() -> tuple[PublishedValue, ...]:
    """All of them, in the order of the source; those without `printed` explain one that is."""
    text = files("calibore.published").joinpath("values.toml").read_text(encoding="utf-8")
    rows: list[dict[str, Any]] = tomllib.loads(text)["value"]
    return tuple(PublishedValue(**row) for row in rows)

"""A row of rings.csv read backwards: what a ring is counted by, when only its row was kept."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from calibore.metrics import RingQuantities
from calibore.profiling._station import unit_suffix
from calibore.uncertainty import Quantity

PLAIN = {"points": "points", "fraction_measured": "fraction", "fraction_directions": "fraction_directions"}


def row_quantities(row: Mapping[str, Any]) -> RingQuantities:
    """The quantities that `ring_row` made `row` of."""
    found: dict[str, Any] = {name: row[column] for name, column in PLAIN.items()}
    for field in fields(RingQuantities):
        column = field.name + unit_suffix(field.name)
        if field.name not in PLAIN and column in row:
            found[field.name] = Quantity(row[column], row[f"u_{column}"])
    return RingQuantities(**found, flags=tuple(row["flags"].split()))

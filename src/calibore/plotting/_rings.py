"""Ring quantities as pictures and reports use them: governing ovality and the worst places."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from calibore.plotting._stations import Floats

OVALITY_DEFINITIONS = {
    "f1216_max": "(Dmax - Dmean) / Dmean",
    "f1216_min": "(Dmean - Dmin) / Dmean",
    "range": "(Dmax - Dmin) / Dmean",
    "harmonic": "second harmonic, 2|c2| / c0",
}
"""Every ovality of rings.csv with its formula; a picture or a page names the one it shows."""

GOVERNING_OVALITY = "the larger of (Dmax - Dmean) / Dmean and (Dmean - Dmin) / Dmean, the two forms of ASTM F1216"


def column(rings: Mapping[str, Any], name: str, *, like: str = "station") -> Floats:
    """Column `name` of the rings as float (n,), NaN throughout where the table has no such column."""
    if name not in rings:
        return np.full(len(rings[like]), np.nan)
    return np.asarray(rings[name], float)


def governing_ovality(rings: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Ovality (n,) [%] in the larger of the two ASTM F1216 forms, and its standard uncertainty (n,)."""
    outward, inward = (column(rings, f"ovality_f1216_{form}_percent") for form in ("max", "min"))
    u_outward, u_inward = (column(rings, f"u_ovality_f1216_{form}_percent") for form in ("max", "min"))
    takes_inward = (inward > outward) | ~np.isfinite(outward)
    return np.where(takes_inward, inward, outward), np.where(takes_inward, u_inward, u_outward)


def worst_stations(rings: Mapping[str, Any], *, count: int, apart: float) -> list[int]:
    """Rows of the `count` worst rings by governing ovality, worst first, at least `apart` [m] from each other.

    Neighbours of a worse ring fill the list only when the pipe offers nothing else, so that one dent does not take
    every place. Rings without an ovality are never among them.
    """
    ovality, _ = governing_ovality(rings)
    axial = column(rings, "axial_m")
    ranked = [int(row) for row in np.argsort(-ovality, kind="stable") if np.isfinite(ovality[row])]
    chosen: list[int] = []
    for row in ranked:
        if all(not abs(axial[row] - axial[other]) < apart for other in chosen):
            chosen.append(row)
        if len(chosen) == count:
            break
    chosen += [row for row in ranked if row not in set(chosen)][: count - len(chosen)]
    return sorted(chosen, key=lambda row: -ovality[row])

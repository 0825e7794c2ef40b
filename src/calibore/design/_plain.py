"""An analysed design as plain data for JSON: SI, every number finite or None."""

from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

from calibore.design._analysis import Analysis
from calibore.design._regions import ImageMap, Region
from calibore.design._tolerances import Tolerance
from calibore.rigs import Rig

FORMAT = "calibore-design-result/1"
MAP_STEP = 5
"""Every fifth row and column of a map: what the pictures show, small enough for a text file."""
DIGITS = 9
SKIPPED = ("rig", "study", "maps")


def plain_analysis(design: Analysis) -> dict[str, Any]:
    """All numbers of `design`: SI units (m, rad), pixels, standard uncertainties (k = 1)."""
    study = design.study
    return {
        "format": FORMAT,
        "units": "SI (m, rad) and px; standard uncertainties (k = 1)",
        "configuration": design.rig.configuration,
        "study": {} if study is None else {**plain(study, skip=("inputs",))},
        "rig": plain_rig(design.rig),
        **plain(design, skip=SKIPPED),
        "u_radius_worst": plain(design.u_worst),
        "maps": [_plain_map(one) for one in design.maps],
    }


def plain_rig(rig: Rig) -> dict[str, Any]:
    """Values and standard uncertainties of all parameters by dotted path; the correlations of the known ones."""
    known = rig.covariance
    u = dict(zip(known.names, known.u.tolist(), strict=True)) if known else {}
    return {
        "parameters": [
            {"name": name, "value": plain(value_of(rig, name)), "u": u.get(name)} for name in rig.parameter_names
        ],
        "correlations": {"names": list(known.names), "matrix": plain(known.correlations)} if known else None,
        "camera": {"width": rig.camera.width, "height": rig.camera.height, "lens": rig.camera.lens.law},
    }


def value_of(rig: Rig, name: str) -> float:
    """The value [SI, px] of the parameter with this dotted path; NaN for the coefficients of series."""
    *table, last = name.split(".")
    if last.startswith("principal_point"):
        return float(rig.camera.principal_point[last.endswith("v")])
    surface = rig.lasers[int(table[1]) if len(table) > 1 else 0].surface
    parts: tuple[Any, ...] = (rig.camera, rig.camera.lens) if table[0] == "camera" else (surface, rig.mount)
    return float(next((getattr(part, last) for part in parts if last in part.__dataclass_fields__), np.nan))


def plain(value: Any, *, skip: tuple[str, ...] = ()) -> Any:
    """Dataclasses become objects, arrays lists, what is not finite None."""
    if is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in fields(value) if field.name not in skip]
        extra = {"limits": plain(value.limits)} if isinstance(value, Tolerance) else {}
        return {name: plain(getattr(value, name)) for name in names} | extra
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def _plain_map(one: ImageMap) -> dict[str, Any]:
    rows = slice(None, None, MAP_STEP if one.v.size > 1 else 1)
    columns = slice(None, None, MAP_STEP)
    found = one.prediction
    values = {"radius": found.radius, "axial": found.axial, "u_radius": found.u_radius, "u_axial": found.u_axial}
    budget = {name: one.valued(share)[rows, columns] for name, share in found.shares.items()}
    return {
        "laser": one.laser,
        "u": plain(one.u[columns]),
        "v": plain(one.v[rows]),
        "region": plain(one.region[rows, columns]),
        "regions": {region.name.lower().replace("_", " "): region.value for region in Region},
        "fraction": {region.name.lower().replace("_", " "): one.fraction(region) for region in Region},
        **{name: plain(one.valued(value)[rows, columns]) for name, value in values.items()},
        "shares": plain(budget),
    }

"""The values of a rig's parameters by their dotted paths."""

from collections.abc import Iterable
from typing import Any

from calibore.optics import Camera
from calibore.rigs._rig import Rig

SERIES = {"polynomial": 3, "pupil_walk": 2}
"""Series of coefficients, and the power of the first; every other power follows."""


def values_of(rig: Rig, names: Iterable[str]) -> dict[str, float]:
    """Values [SI, px] of the parameters `names` (`Rig.parameter_names`)."""
    return {name: value_of(rig, name) for name in names}


def value_of(rig: Rig, name: str) -> float:
    """Value [SI, px] of one parameter."""
    *table, key = name.split(".")
    if table[0] != "laser":
        return camera_value(rig.camera, key)
    surface: Any = rig.lasers[int(table[1]) if len(table) > 1 else 0].surface
    return float(getattr(surface if key in surface.parameter_names else rig.mount, key))


def camera_value(camera: Camera, key: str) -> float:
    """Value [px, SI] of a camera's parameter, `key` without "camera."."""
    of: Any = camera
    if key.startswith("principal_point"):
        return float(of.principal_point[key.endswith("v")])
    if key.startswith("port_"):
        return float(getattr(of.port, key.removeprefix("port_")))
    series, _, power = key.rpartition("_")
    if series in SERIES:
        values = of.lens.polynomial if series == "polynomial" else of.pupil_walk
        return float(values[(int(power) - SERIES[series]) // 2])
    return float(getattr(of if key == "aspect" else of.lens, key))

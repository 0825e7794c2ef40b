"""The true values of a rig's parameters by their dotted names, as truth.npz holds them."""

from typing import Any

from calibore.optics import Camera
from calibore.rigs import Rig

SERIES = {"polynomial": 3, "pupil_walk": 2}
"""Series of coefficients, and the power of the first; every other power follows."""


def camera_values(camera: Camera) -> dict[str, float]:
    """By `Camera.parameter_names` [SI, px]."""
    return {name: _of_camera(camera, name.removeprefix("camera.")) for name in camera.parameter_names}


def rig_values(rig: Rig) -> dict[str, float]:
    """By `Rig.parameter_names` [SI, px]."""
    values: dict[str, Any] = {}
    for number, laser in enumerate(rig.lasers):
        surface: Any = laser.surface
        values |= {f"{rig.laser_table(number)}.{key}": getattr(surface, key) for key in surface.parameter_names}
    values |= {f"laser.{key}": getattr(rig.mount, key) for key in rig.mount.parameter_names}
    return {name: float(value) for name, value in values.items()} | camera_values(rig.camera)


def _of_camera(camera: Any, key: str) -> float:
    if key.startswith("principal_point"):
        return float(camera.principal_point[key.endswith("v")])
    if key.startswith("port_"):
        return float(getattr(camera.port, key.removeprefix("port_")))
    series, _, power = key.rpartition("_")
    if series in SERIES:
        values = camera.lens.polynomial if series == "polynomial" else camera.pupil_walk
        return float(values[(int(power) - SERIES[series]) // 2])
    return float(getattr(camera if key == "aspect" else camera.lens, key))

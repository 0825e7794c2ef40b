"""The true values of a rig's parameters by their dotted names, as truth.npz holds them."""

from calibore.optics import Camera
from calibore.rigs import Rig, camera_value, values_of


def camera_values(camera: Camera) -> dict[str, float]:
    """By `Camera.parameter_names` [SI, px]."""
    return {name: camera_value(camera, name.removeprefix("camera.")) for name in camera.parameter_names}


def rig_values(rig: Rig) -> dict[str, float]:
    """By `Rig.parameter_names` [SI, px]."""
    return values_of(rig, rig.parameter_names)

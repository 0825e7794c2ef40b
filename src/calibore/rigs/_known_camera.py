"""A camera as a calibration knows it, with a rig or without."""

from dataclasses import dataclass
from pathlib import Path

from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs._reading import holds_rig, read_part, read_rig
from calibore.rigs._rig import Rig
from calibore.rigs._valid import ValidRegion
from calibore.uncertainty import Covariance


@dataclass(frozen=True, eq=False)
class KnownCamera:
    """`camera` with the `covariance` of its parameters (names `camera.*`, SI or px), None where nothing is stated, the
    `degrees_of_freedom` of the scatter that rests on, None where unknown, and where it is `valid`.
    """

    camera: Camera
    covariance: Covariance | None = None
    degrees_of_freedom: float | None = None
    valid: ValidRegion | None = None


def read_camera(path: Path | str, *, drift: bool = True) -> KnownCamera:
    """The camera of a whole rig file, or of one that holds a camera only; raises InputError where it holds none.

    Its covariance is the marginal one: what a laser's parameters share with it is left out. `drift` as in `read_rig`.
    """
    camera, known = read_part(Path(path), drift=drift)
    names = [name for name in known.covariance.names if name.startswith("camera.")] if known.covariance else []
    unknown = set(names) - set(camera.parameter_names)
    if unknown:
        allowed = ", ".join(camera.parameter_names)
        raise InputError(f"{path}: this camera has no parameter {', '.join(sorted(unknown))}; allowed: {allowed}.")
    covariance = known.covariance.restricted(names) if known.covariance and names else None
    return KnownCamera(camera, covariance, known.degrees_of_freedom, known.valid)


def read_rig_or_camera(path: Path | str, *, drift: bool = True) -> Rig | KnownCamera:
    """The rig of a whole rig file, the camera of one that holds a camera only. `drift` as in `read_rig`."""
    return read_rig(path, drift=drift) if holds_rig(Path(path)) else read_camera(path, drift=drift)

"""A camera as a calibration knows it, with a rig or without."""

from dataclasses import dataclass
from pathlib import Path

from calibore.optics import Camera
from calibore.rigs._reading import read_part
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


def read_camera(path: Path | str) -> KnownCamera:
    """The camera of a whole rig file, or of one that holds a camera only; raises InputError where it holds none.

    Its covariance is the marginal one: what a laser's parameters share with it is left out.
    """
    camera, known = read_part(Path(path))
    names = [name for name in known.covariance.names if name.startswith("camera.")] if known.covariance else []
    covariance = known.covariance.restricted(names) if known.covariance and names else None
    return KnownCamera(camera, covariance, known.degrees_of_freedom, known.valid)

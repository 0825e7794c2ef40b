"""The two sides of a difference, whatever they are: rig files, camera files or calibrations."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from calibore.calibration._calibration import Calibration
from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import KnownCamera, Rig, ValidRegion, values_of
from calibore.uncertainty import Covariance

WELL_KNOWN = float("inf")
Known = Rig | KnownCamera | Calibration


@dataclass(frozen=True, eq=False)
class Side:
    """`values` of the parameters by dotted path; `covariance` of none where nothing is `stated`."""

    camera: Camera
    rig: Rig | None
    values: Mapping[str, float]
    covariance: Covariance
    stated: bool
    degrees_of_freedom: float
    valid: ValidRegion | None


def side_of(one: Known) -> Side:
    """What there is to compare; raises InputError for calibrations of probes and pupils, which have no camera."""
    rig = one if isinstance(one, Rig) else one.rig if isinstance(one, Calibration) else None
    camera = rig.camera if rig else one.camera
    if camera is None:
        kind = one.kind if isinstance(one, Calibration) else "calibration"
        raise InputError(f"A {kind} calibration has no camera to compare; give those of a lens or of a rig.")
    values = values_of(rig, rig.parameter_names) if rig else camera_values(camera)
    stated = one.covariance if one.covariance is not None or rig is None else rig.covariance
    known = [name for name in stated.names if name in values] if stated else []
    freedom = one.degrees_of_freedom
    return Side(
        camera,
        rig,
        values,
        stated.restricted(known) if stated else Covariance.independent({}),
        bool(known),
        WELL_KNOWN if freedom is None else freedom,
        one.valid,
    )


def camera_values(camera: Camera) -> dict[str, float]:
    """Values of `camera.parameter_names`."""
    lens, (u, v), port = camera.lens, camera.principal_point, camera.port
    values: dict[str, Any] = {"k": lens.k, "c1": lens.c1, "c2": lens.c2, "aspect": camera.aspect}
    values |= {f"polynomial_{2 * i + 3}": value for i, value in enumerate(lens.polynomial)}
    values |= {"principal_point_u": u, "principal_point_v": v}
    values |= {f"pupil_walk_{2 * i + 2}": value for i, value in enumerate(camera.pupil_walk)}
    values |= {f"port_{one.name}": getattr(port, one.name) for one in fields(port)} if port else {}
    return {f"camera.{name}": float(value) for name, value in values.items()}


def alike(a: Side, b: Side) -> bool:
    """Whether both cameras are described by the same parameters, so that these can be compared one by one."""
    first, second = a.camera.lens, b.camera.lens
    same = (first.law, first.half_height) == (second.law, second.half_height)
    return same and a.camera.parameter_names == b.camera.parameter_names


def alike_rigs(a: Side, b: Side) -> bool:
    """The same of the whole rigs."""
    return alike(a, b) and set(a.values) == set(b.values)

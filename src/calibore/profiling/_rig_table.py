"""The rig as rows of a table: every parameter with its value, its standard uncertainty where stated, and its unit."""

from dataclasses import fields
from typing import Any

from calibore.profiling._job import Job
from calibore.rigs import Rig

UNITS = {
    **dict.fromkeys(("baseline", "offset", "port_thickness", "port_distance"), "m"),
    **dict.fromkeys(("aim", "half_angle", "clock"), "rad"),
    **dict.fromkeys(("k", "principal_point_u", "principal_point_v"), "px"),
}
"""By the last part of a parameter's name; the others are pure numbers."""


def describe_rig(job: Job, *, file: str | None) -> dict[str, Any]:
    """Configuration, lens and parameters of the rig, with standard uncertainties where they are stated."""
    rig = job.rig
    stated = dict(zip(job.covariance.names, job.covariance.u, strict=True))
    parameters = [
        {"name": name, "value": float(value), "u": float(stated[name]) if name in stated else None, "unit": unit(name)}
        for name, value in values_of(rig).items()
    ]
    return {
        "configuration": rig.configuration,
        "file": file,
        "lens": rig.camera.lens.law,
        "image": [rig.camera.width, rig.camera.height],
        "parameters": parameters,
        "default_uncertainty": rig.default_uncertainty,
        "stripe_px": rig.stripe,
        "degrees_of_freedom": rig.degrees_of_freedom,
        "valid": rig.valid and {"zenith_rad": rig.valid.zenith, "radius_m": rig.valid.radius},
    }


def values_of(rig: Rig) -> dict[str, float]:
    """The parameters of the lasers and of the camera, SI or px, by the names that uncertainties go by."""
    camera, lens, (u, v) = rig.camera, rig.camera.lens, rig.camera.principal_point
    values: dict[str, float] = {}
    for number, laser in enumerate(rig.lasers):
        table, surface = rig.laser_table(number), laser.surface
        values |= {f"{table}.{name}": getattr(surface, name) for name in surface.parameter_names}
    values |= {"camera.k": lens.k, "camera.c1": lens.c1, "camera.c2": lens.c2, "camera.aspect": camera.aspect}
    values |= {f"camera.polynomial_{2 * i + 3}": p for i, p in enumerate(lens.polynomial)}
    values |= {"camera.principal_point_u": u, "camera.principal_point_v": v}
    values |= {f"camera.pupil_walk_{2 * i + 2}": walk for i, walk in enumerate(camera.pupil_walk)}
    port = camera.port
    return values | ({f"camera.port_{one.name}": getattr(port, one.name) for one in fields(port)} if port else {})


def unit(name: str) -> str:
    """`"laser.0.aim"` -> `"rad"`, `"camera.pupil_walk_2"` -> `"m/rad^2"`."""
    last = name.split(".")[-1]
    if last.startswith("pupil_walk_"):
        return f"m/rad^{last.rsplit('_', 1)[1]}"
    return UNITS.get(last, "")

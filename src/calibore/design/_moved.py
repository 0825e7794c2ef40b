"""The same rig with some of its parameters changed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from calibore.errors import InputError
from calibore.rigs import Rig


def moved(rig: Rig, changes: Mapping[str, float]) -> Rig:
    """`rig` with `changes` [SI, px] added to the parameters that their dotted paths name."""
    unknown = set(changes) - set(rig.parameter_names)
    if unknown:
        raise InputError(
            f"This rig has no parameter {', '.join(sorted(unknown))}; allowed: {', '.join(rig.parameter_names)}."
        )
    lasers = tuple(
        replace(laser, surface=_changed(laser.surface, changes, rig.laser_table(number)))
        for number, laser in enumerate(rig.lasers)
    )
    camera = rig.camera
    u, v = camera.principal_point
    centre = u + changes.get("camera.principal_point_u", 0.0), v + changes.get("camera.principal_point_v", 0.0)
    camera = replace(camera, lens=_changed(camera.lens, changes, "camera"), principal_point=centre)
    return replace(
        rig, lasers=lasers, camera=_changed(camera, changes, "camera"), mount=_changed(rig.mount, changes, "laser")
    )


def _changed(part: Any, changes: Mapping[str, float], table: str) -> Any:
    """`part` with those of its fields moved that the changes name."""
    paths = ((name, f"{table}.{name}") for name in part.__dataclass_fields__)
    return replace(part, **{name: getattr(part, name) + changes[path] for name, path in paths if path in changes})

"""The same rig with other values of its parameters."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.lasers import Cone, LaserSurface
from calibore.optics import Camera
from calibore.rigs._rig import Rig

PRINCIPAL_POINT = ("principal_point_u", "principal_point_v")


def moved(rig: Rig, changes: Mapping[str, float]) -> Rig:
    """`rig` with `changes` [SI, px] added to the parameters they name (`Rig.parameter_names`); its covariance stays.

    Raises InputError where a name is unknown or the changed rig cannot be.
    """
    unknown = set(changes) - set(rig.parameter_names)
    if unknown:
        raise InputError(
            f"This rig has no parameter {', '.join(sorted(unknown))}; allowed: {', '.join(rig.parameter_names)}."
        )
    lasers = tuple(
        replace(laser, surface=_surface(laser.surface, _of(changes, rig.laser_table(number))))
        for number, laser in enumerate(rig.lasers)
    )
    mount = _added(rig.mount, _of(changes, "laser"), rig.mount.parameter_names)
    return replace(rig, lasers=lasers, mount=mount, camera=_camera(rig.camera, _of(changes, "camera")))


def _of(changes: Mapping[str, float], table: str) -> dict[str, float]:
    """The changes of one table, by key."""
    return {name.removeprefix(f"{table}."): change for name, change in changes.items() if name.startswith(f"{table}.")}


def _added(part: Any, changes: Mapping[str, float], names: tuple[str, ...]) -> Any:
    values = {name: getattr(part, name) + changes[name] for name in names if name in changes}
    return replace(part, **values) if values else part


def _surface(surface: LaserSurface, changes: Mapping[str, float]) -> LaserSurface:
    if isinstance(surface, Cone) and surface.baseline + changes.get("baseline", 0.0) < 0:
        return _across_axis(surface, changes)
    return _added(surface, changes, surface.parameter_names)


def _across_axis(cone: Cone, changes: Mapping[str, float]) -> Cone:
    """The apex moved to the other side of the rig axis: the same cone in its own terms."""
    values = {name: getattr(cone, name) + changes.get(name, 0.0) for name in cone.parameter_names}
    turned = {"baseline": -values["baseline"], "aim": -values["aim"], "clock": values["clock"] + np.pi}
    return replace(cone, **{**values, **turned})


def _camera(camera: Camera, changes: Mapping[str, float]) -> Camera:
    if not changes:
        return camera
    lens = _added(camera.lens, changes, ("k", "c1", "c2"))
    if camera.lens.polynomial:
        lens = replace(lens, polynomial=_powers(lens.polynomial, changes, "polynomial", first=3))
    centre = [
        value + changes.get(name, 0.0) for value, name in zip(camera.principal_point, PRINCIPAL_POINT, strict=True)
    ]
    walk = _powers(camera.pupil_walk, changes, "pupil_walk", first=2)
    port = camera.port
    if port is not None:
        port = _added(port, _of_port(changes), tuple(field.name for field in fields(port)))
    camera = replace(camera, lens=lens, principal_point=(centre[0], centre[1]), pupil_walk=walk, port=port)
    return _added(camera, changes, ("aspect",))


def _powers(values: tuple[float, ...], changes: Mapping[str, float], key: str, *, first: int) -> tuple[float, ...]:
    """Coefficients of every other power from the `first`."""
    return tuple(value + changes.get(f"{key}_{first + 2 * i}", 0.0) for i, value in enumerate(values))


def _of_port(changes: Mapping[str, float]) -> dict[str, float]:
    return {name.removeprefix("port_"): change for name, change in changes.items() if name.startswith("port_")}

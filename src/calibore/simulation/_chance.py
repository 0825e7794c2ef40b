"""Rigs, walls and poses by chance, for studies over many of them."""

from dataclasses import replace
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.rigs import Laser, Rig
from calibore.simulation._parts import Dent, Harmonic, LateralOpening, Ovality, Rail, Roughness, WallPart
from calibore.simulation._wall import PipeWall
from calibore.uncertainty import Covariance

BASELINE_PARAMETERS = (0.6, 3.0)  # baseline / nominal radius, the dissertation's range
STEEPEST = np.radians(1.0)  # of laser planes and poses
OFF_CENTRE = 0.04  # of the nominal radius
FILLING = (0.55, 0.75)  # radius of the nominal ring over the principal point's distance from the image border


def random_wall(rng: np.random.Generator, *, features: bool = True) -> PipeWall:
    """A pipe of 0.05 ... 0.5 m radius, oval up to 3 %, rough; with `features` perhaps dented, with a lateral or rail.
    They lie within a nominal radius of axial 0.
    """
    radius = float(np.exp(rng.uniform(np.log(0.05), np.log(0.5))))
    parts: list[WallPart] = [
        Ovality((rng.uniform(0, 3), rng.uniform(0, 3)), axial=(-radius, radius), axis=rng.uniform(0, np.pi))
    ]
    parts += [Harmonic(order, rng.uniform(0, 0.003) * radius / order, rng.uniform(0, 2 * np.pi)) for order in (3, 4, 5)]
    clock, axial = rng.uniform(0, 2 * np.pi, 2), rng.uniform(-1, 1, 2) * radius
    size, present = rng.uniform(0.5, 1.0, 3), rng.uniform(size=3) < (0.6, 0.4, 0.4)
    if features and present[0]:
        parts.append(Dent(0.06 * size[0] * radius, clock[0], axial[0], 0.2 * size[0], 0.3 * radius))
    if features and present[1]:
        parts.append(LateralOpening(0.3 * size[1] * radius, 0.1 * radius, clock[1], axial[1], edge=0.1 * radius))
    parts.append(Roughness(2e-4 * radius, max(0.002, 0.02 * radius), int(rng.integers(2**31))))
    if features and present[2]:
        parts.append(Rail(0.1 * size[2] * radius, 0.2 * radius, edge=0.007 * radius))
    return PipeWall(radius, tuple(parts))


def random_rig(rng: np.random.Generator, nominal_radius: float, *, width: int = 512, height: int = 384) -> Rig:
    """A perpendicular-plane rig as its file states it: any of the five lens laws, baseline 0.6 ... 3 nominal radii,
    plane tilted within 1 deg, principal point off the centre, ring inside the image, with stated uncertainties of all
    of them. The true rig behind it is `draw_rig(rig, rng)`.
    """
    law = str(rng.choice(tuple(LENS_LAWS)))
    baseline = float(np.exp(rng.uniform(*np.log(BASELINE_PARAMETERS)))) * nominal_radius
    centre = np.array([width - 1, height - 1]) / 2 + rng.uniform(-0.04, 0.04, 2) * height
    border = min(centre.min(), width - 1 - centre[0], height - 1 - centre[1])
    unit_radius = Lens(law, 1.0, height / 2).image_radius(np.arctan2(nominal_radius, baseline))
    k = float(rng.uniform(*FILLING) * border / unit_radius)
    tilt, towards = np.tan(STEEPEST) * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    surface = Plane(baseline, float(tilt * np.cos(towards)), float(tilt * np.sin(towards)))
    uncertainty = {
        "laser.baseline": 5e-4 * baseline,
        "laser.tilt_x": 5e-4,
        "laser.tilt_y": 5e-4,
        "camera.k": 5e-4 * k,
        "camera.principal_point_u": 0.2,
        "camera.principal_point_v": 0.2,
    }
    camera = Camera(width, height, Lens(law, k, height / 2), (float(centre[0]), float(centre[1])))
    return Rig("perpendicular-plane", camera, (Laser(surface, "red"),), covariance=Covariance.independent(uncertainty))


def random_pose(rng: np.random.Generator, rig: Rig, nominal_radius: float) -> Pose:
    """pipe_from_rig of a rig off-centre by up to 4 % of the nominal radius where the laser meets the wall, rolled,
    tilted within 1 deg, its laser plane within half a nominal radius of axial 0.
    """
    roll, pitch, yaw = rng.uniform(-1, 1, 3) * (0.3, STEEPEST / np.sqrt(2), STEEPEST / np.sqrt(2))
    turned_only = Pose.from_roll_pitch_yaw(roll, pitch, yaw)
    offset, towards = OFF_CENTRE * nominal_radius * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    target = np.array([offset * np.cos(towards), offset * np.sin(towards), rng.uniform(-0.5, 0.5) * nominal_radius])
    return Pose(turned_only.rotation, target - turned_only.apply(np.array([0.0, 0.0, _plane_of(rig).baseline])))


def draw_rig(stated: Rig, rng: np.random.Generator) -> Rig:
    """A true rig that `stated` may describe: its parameters drawn from the stated covariance (normal); same where none
    is stated.
    """
    if stated.covariance is None:
        return stated
    shift = stated.covariance.factor() @ rng.standard_normal(len(stated.covariance.names))
    changes = dict(zip(stated.covariance.names, shift.tolist(), strict=True))
    camera, laser = stated.camera, stated.lasers[0]
    lens = replace(camera.lens, **_moved(camera.lens, changes, "camera", ("k", "c1", "c2")))
    u, v = camera.principal_point
    centre = u + changes.get("camera.principal_point_u", 0.0), v + changes.get("camera.principal_point_v", 0.0)
    camera = replace(camera, lens=lens, principal_point=centre, **_moved(camera, changes, "camera", ("aspect",)))
    surface = _plane_of(stated)
    surface = replace(surface, **_moved(surface, changes, "laser", surface.parameter_names))
    return replace(stated, camera=camera, lasers=(replace(laser, surface=surface), *stated.lasers[1:]))


def _plane_of(rig: Rig) -> Plane:
    surface = rig.lasers[0].surface
    if not isinstance(surface, Plane):
        raise InputError(f"Only laser planes can be simulated, got a {type(surface).__name__}; use a Plane.")
    return surface


def _moved(part: object, changes: dict[str, float], table: str, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(part, name) + changes[f"{table}.{name}"] for name in names if f"{table}.{name}" in changes}

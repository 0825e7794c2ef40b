"""Walls, poses and true rigs by chance, for studies over many of them."""

import numpy as np

from calibore.geometry import Pose
from calibore.lasers import Beam, Cone, Plane
from calibore.rigs import Rig, SideFacing
from calibore.rigs._moving import moved
from calibore.simulation._parts import Dent, Harmonic, LateralOpening, Ovality, Rail, Roughness, WallPart
from calibore.simulation._survey import head_pose
from calibore.simulation._wall import PipeWall

STEEPEST = np.radians(1.0)
OFF_CENTRE = 0.04  # of the nominal radius


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


def random_pose(rng: np.random.Generator, rig: Rig, nominal_radius: float) -> Pose:
    """pipe_from_rig of a rig off-centre by up to 4 % of the nominal radius where the light meets the wall, rolled,
    tilted within 1 deg, its light within half a nominal radius of axial 0; of a side-facing head, turned anywhere.
    """
    roll, pitch, yaw = rng.uniform(-1, 1, 3) * (0.3, STEEPEST / np.sqrt(2), STEEPEST / np.sqrt(2))
    turned_only = Pose.from_roll_pitch_yaw(roll, pitch, yaw)
    offset, towards = OFF_CENTRE * nominal_radius * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    target = np.array([offset * np.cos(towards), offset * np.sin(towards), rng.uniform(-0.5, 0.5) * nominal_radius])
    ahead = np.array([0.0, 0.0, _reach(rig, nominal_radius)])
    pose = Pose(turned_only.rotation, target - turned_only.apply(ahead))
    return pose @ head_pose(rng.uniform(0, 2 * np.pi)) if isinstance(rig.mount, SideFacing) else pose


def _reach(rig: Rig, nominal_radius: float) -> float:
    """How far [m] ahead of the pupil the light falls on the nominal wall, about."""
    surface = rig.lasers[0].surface
    if isinstance(surface, Plane):
        return surface.baseline
    if isinstance(surface, Cone):
        return surface.offset + nominal_radius / float(np.tan(surface.half_angle))
    if isinstance(surface, Beam):
        return surface.z + nominal_radius / float(np.tan(surface.zenith))
    return 0.0


def draw_rig(stated: Rig, rng: np.random.Generator) -> Rig:
    """A true rig that `stated` may describe: its parameters drawn from the stated covariance (normal); same where none
    is stated.
    """
    if stated.covariance is None:
        return stated
    shift = stated.covariance.factor() @ rng.standard_normal(len(stated.covariance.names))
    return moved(stated, dict(zip(stated.covariance.names, shift.tolist(), strict=True)))

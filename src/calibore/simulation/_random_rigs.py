"""Rigs of every kind by chance, within what people build, with what their files would state of their uncertainty."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.lasers import Beam, Cone, LaserSurface, Plane, Sheet, ring_angles
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.rigs import FORWARD, Laser, Mount, Rig, SideFacing, project_ring
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]

PLANE_BASELINES = (0.6, 3.0)  # over the nominal radius, the dissertation's range; so are the next two
BASELINES, PROJECTIONS = (0.25, 0.75), (1.0, 3.0)
RANGES = np.array([0.75, 1.3])  # over the nominal radius, that a side-facing camera sees
STEEPEST = np.radians(1.0)  # of laser planes
FILLING = (0.55, 0.75)  # greatest image radius over the principal point's distance from the image border
SEEN = 0.92  # the same of the ranges of a side-facing camera
BEAMS = 4
U_LENGTH = 5e-4  # of the nominal radius, standard uncertainty of lengths of the laser
U_ANGLE = 5e-4  # rad, of its angles and slopes


@dataclass(frozen=True, eq=False)
class Light:
    """The surfaces of a rig's lasers, what its file states of them, and where the camera stands."""

    surfaces: tuple[LaserSurface, ...]
    covariance: Covariance
    mount: Mount = FORWARD


def random_rig(
    rng: np.random.Generator,
    nominal_radius: float,
    *,
    kind: str = "perpendicular-plane",
    law: str | None = None,
    width: int = 512,
    height: int = 384,
) -> Rig:
    """A rig of the configuration `kind` as its file states it: lens `law`, or any of the five, principal point off the
    centre, the light on a nominal wall inside the image, with stated uncertainties of all parameters. Planes stand 0.6
    ... 3 nominal radii ahead, tilted within 1 deg; cones and side-facing heads have baselines of 0.25 ... 0.75. The
    true rig behind it is `draw_rig(rig, rng)`. A rotating spot has a line sensor, one row high.
    """
    if kind not in LIGHTS:
        raise InputError(f"There are no random rigs of the kind {kind}; allowed: {', '.join(LIGHTS)}.")
    height = 1 if kind == "rotating-spot" else height
    law = law or str(rng.choice(tuple(LENS_LAWS)))
    light = LIGHTS[kind](rng, nominal_radius)
    centre = np.array([width - 1, height - 1]) / 2 + rng.uniform(-0.04, 0.04, 2) * (
        height if height > 1 else (width, 0)
    )
    side = isinstance(light.mount, SideFacing)
    border = np.minimum(centre, (width - 1, height - 1) - centre)[: 1 if side else 2].min()
    lasers = tuple(Laser(surface, "red") for surface in light.surfaces)
    unit = Rig(kind, Camera(width, height, Lens(law, 1.0, height / 2), (0.0, 0.0)), lasers, mount=light.mount)
    k = float((SEEN if side else rng.uniform(*FILLING)) * border / _image_radius(unit, nominal_radius))
    camera = Camera(width, height, Lens(law, k, height / 2), (float(centre[0]), float(centre[1])))
    points = dict.fromkeys(("camera.principal_point_u", "camera.principal_point_v"), 0.2)
    stated = light.covariance.joined(Covariance.independent({"camera.k": 5e-4 * k, **points}))
    return Rig(kind, camera, lasers, mount=light.mount, covariance=stated)


def _image_radius(unit: Rig, nominal_radius: float) -> float:
    """The greatest distance [px] of the light on a nominal wall from the principal point at (0, 0), for k = 1."""
    if isinstance(unit.mount, SideFacing):
        ends = np.zeros((2, 3))
        ends[:, 1] = RANGES * nominal_radius
        return float(np.abs(unit.project(ends)[0]).max())
    if isinstance(unit.lasers[0].surface, Beam):
        return float(np.hypot(*unit.project(_targets(unit, nominal_radius))).max())
    rings = (project_ring(unit, nominal_radius, 72, laser=number)[1:] for number in range(len(unit.lasers)))
    return max(float(np.hypot(u, v).max()) for u, v in rings)


def _targets(unit: Rig, nominal_radius: float) -> Array:
    """Where the beams meet the nominal wall (n, 3)."""
    points = []
    for laser in unit.lasers:
        beam = laser.surface
        assert isinstance(beam, Beam)
        (x, y, _), (a, b, _) = beam.source, beam.direction
        square, along = a * a + b * b, x * a + y * b
        root = np.sqrt(along**2 + square * (nominal_radius**2 - x * x - y * y))
        points.append(beam.source + (root - along) / square * beam.direction)
    return np.array(points)


def _plane(rng: np.random.Generator, radius: float) -> Light:
    baseline = float(np.exp(rng.uniform(*np.log(PLANE_BASELINES)))) * radius
    tilt, towards = np.tan(STEEPEST) * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    plane = Plane(baseline, float(tilt * np.cos(towards)), float(tilt * np.sin(towards)))
    u = {"laser.baseline": 5e-4 * baseline, "laser.tilt_x": U_ANGLE, "laser.tilt_y": U_ANGLE}
    return Light((plane,), Covariance.independent(u))


def _ring_cone(rng: np.random.Generator, radius: float, clock: float, table: str) -> tuple[Cone, Covariance]:
    """A cone that lights a ring across the axis; aim and half angle are known through baseline and projection."""
    baseline, projection = (rng.uniform(*limits) * radius for limits in (BASELINES, PROJECTIONS))
    jacobian = np.vstack([[1.0, 0.0], ring_angles(baseline, projection, radius)[2]]) * U_LENGTH * radius
    names = (f"{table}.baseline", f"{table}.aim", f"{table}.half_angle")
    apart = Covariance.independent({f"{table}.clock": U_ANGLE, f"{table}.offset": U_LENGTH * radius})
    cone = Cone.for_ring(baseline, projection, radius, clock=clock)
    return cone, Covariance(names, jacobian @ jacobian.T).joined(apart)


def _single_cone(rng: np.random.Generator, radius: float) -> Light:
    cone, covariance = _ring_cone(rng, radius, rng.uniform(0, 2 * np.pi), "laser")
    return Light((cone,), covariance)


def _dual_cone(rng: np.random.Generator, radius: float) -> Light:
    clock, apart = rng.uniform(0, 2 * np.pi), rng.uniform(np.pi / 2, np.pi)
    (one, first), (two, second) = (
        _ring_cone(rng, radius, clock + number * apart, f"laser.{number}") for number in (0, 1)
    )
    return Light((one, two), first.joined(second))


def _coaxial_cone(rng: np.random.Generator, radius: float) -> Light:
    """The laser stands ahead of the camera or behind it."""
    throw, offset = rng.uniform(0.5, 1.5) * radius, rng.uniform(0.4, 1.5) * radius
    behind = rng.uniform() < 0.5
    half_angle = float(np.arctan2(radius, throw + 2 * offset if behind else throw))
    return _on_axis(Cone(0.0, 0.0, half_angle, offset=-offset if behind else offset), radius)


def _reversed_cone(rng: np.random.Generator, radius: float) -> Light:
    """The light of a laser ahead of the camera comes back to a ring between them."""
    ring, throw = rng.uniform(0.8, 2.0) * radius, rng.uniform(0.3, 1.0) * radius
    return _on_axis(Cone(0.0, 0.0, float(np.pi - np.arctan2(radius, throw)), offset=ring + throw), radius)


def _on_axis(cone: Cone, radius: float) -> Light:
    u = {"laser.half_angle": U_ANGLE, "laser.offset": U_LENGTH * radius}
    return Light((cone,), Covariance.independent(u))


def _asymmetric_cone(rng: np.random.Generator, radius: float) -> Light:
    """Its nearest light falls at most 65 deg from the camera's axis."""
    baseline, projection = rng.uniform(0.25, 0.5) * radius, rng.uniform(*PROJECTIONS)
    offset, clock = rng.uniform(-0.2, 0.2) * radius, rng.uniform(0, 2 * np.pi)
    cone = Cone(baseline, 0.0, float(np.arctan(1 / projection)), clock, offset if projection > 1.5 else abs(offset))
    u = {"laser.baseline": U_LENGTH * radius, "laser.half_angle": U_ANGLE, "laser.clock": U_ANGLE}
    return Light((cone,), Covariance.independent({**u, "laser.offset": U_LENGTH * radius}))


def _side_facing(rng: np.random.Generator, radius: float) -> Light:
    """The camera is aimed at the middle of the angles of its `RANGES`; aim and baseline are known through the baseline
    and the range at which the camera's axis meets the sheet.
    """
    baseline = float(rng.uniform(*BASELINES) * radius)
    aim = float(np.arctan2(baseline, RANGES * radius).mean())
    sheet = Sheet(float(rng.uniform(-1, 1) * 2e-3 * radius), *(rng.uniform(-1, 1, 2) * 3e-3).tolist())
    slopes = np.array([np.sin(aim) * np.cos(aim), -(np.sin(aim) ** 2)]) / baseline
    jacobian = np.array([[1.0, 0.0], slopes]) * U_LENGTH * radius
    head = Covariance(("laser.baseline", "laser.aim"), jacobian @ jacobian.T)
    sheet_u = {"laser.offset": U_LENGTH * radius, "laser.skew": U_ANGLE, "laser.lean": U_ANGLE}
    return Light((sheet,), head.joined(Covariance.independent(sheet_u)), SideFacing(baseline, aim))


def _spot_array(rng: np.random.Generator, radius: float) -> Light:
    """Beams from one point beside the camera to points evenly round the wall."""
    baseline, projection = (float(rng.uniform(*limits) * radius) for limits in (BASELINES, PROJECTIONS))
    x, y = xy_of(rng.uniform(0, 2 * np.pi), baseline)
    clocks = rng.uniform(0, 2 * np.pi) + np.arange(BEAMS) * (2 * np.pi / BEAMS)
    beams, u = [], {}
    for number, (a, b) in enumerate(zip(*xy_of(clocks, radius), strict=True)):
        zenith, clock = np.arctan2(np.hypot(a - x, b - y), projection), np.arctan2(a - x, y - b)
        beams.append(Beam(float(x), float(y), 0.0, float(zenith), float(clock)))
        u |= {f"laser.{number}.{name}": U_LENGTH * radius for name in ("x", "y", "z")}
        u |= {f"laser.{number}.{name}": U_ANGLE for name in ("zenith", "clock")}
    return Light(tuple(beams), Covariance.independent(u))


LIGHTS: dict[str, Callable[[np.random.Generator, float], Light]] = {
    "perpendicular-plane": _plane,
    "single-cone": _single_cone,
    "dual-cone": _dual_cone,
    "coaxial-cone": _coaxial_cone,
    "asymmetric-cone": _asymmetric_cone,
    "reversed-cone": _reversed_cone,
    "side-facing": _side_facing,
    "rotating-spot": _side_facing,
    "spot-array": _spot_array,
}
RIG_KINDS = tuple(LIGHTS)

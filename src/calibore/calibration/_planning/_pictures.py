"""What a picture that is not taken yet would tell of a rig: its rows of a least-squares fit."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._planning._light import STEP, Picture, across_line, in_picture, picture_of_light
from calibore.calibration._planning._shots import Shot
from calibore.calibration._planning._targets import PlannedBoard, PlannedRings, PlannedTarget
from calibore.geometry import xy_of
from calibore.lasers import Plane
from calibore.optics import Camera
from calibore.rigs import Rig

Array = NDArray[Any]
FEWEST_RINGS = 4
PLACED = (1e-4, 2e-3)
"""m and slope: how well a target stands in the light, judged by eye."""


class _Flat(NamedTuple):
    """Marks on a flat target: points (n, 3) of the camera frame from its `origin`, and their unit vectors on it."""

    points: Array
    origin: Array
    outwards: Array


def picture_of(rig: Rig, target: PlannedTarget, shot: Shot) -> Picture | None:
    """What `shot` would tell; None where the camera does not see enough of the target."""
    if isinstance(target, PlannedRings):
        return _of_rings(rig, target, shot)
    if isinstance(target, PlannedBoard):
        return _of_board(rig, target, shot)
    return picture_of_light(rig, target, shot)


def _of_rings(rig: Rig, target: PlannedRings, shot: Shot) -> Picture | None:
    angle = np.tile(np.arange(target.marks) * (2 * np.pi / target.marks), target.rings)
    radius, ring = np.repeat(target.radii, target.marks), np.repeat(np.arange(target.rings), target.marks)
    flat, ahead, turned = (_placed(rig, shot, radius, a) for a in (angle, angle + STEP, angle - STEP))
    normal = _across(rig.camera, ahead.points, turned.points)
    seen = _in_image(rig.camera, flat.points)
    whole = [number for number in range(target.rings) if seen[ring == number].mean() > 0.5]
    if len(whole) < FEWEST_RINGS:
        return None
    kept = seen & np.isin(ring, whole)
    rows, beside, by_point = _through_camera(rig, flat, normal[:, None], kept)
    radial = np.einsum("nki,ni->nk", by_point, flat.outwards[kept])[:, 0]
    shared = (ring[kept][:, None] == whole) * radial[:, None] / target.noise
    beside_u = np.full(6, np.inf)
    if shot.in_light:
        rows, beside = _with_light(rig, rows, beside), beside @ _along_plane(rig)
        beside_u = np.array([PLACED[1], PLACED[1], np.inf, np.inf, np.inf, PLACED[0]])
    keys = tuple(f"ring {number + 1}" for number in whole)
    shared_u = np.full(len(whole), target.u_ring)
    return Picture(rows / target.noise, beside / target.noise, beside_u, shared, shared_u, keys)


def _of_board(rig: Rig, target: PlannedBoard, shot: Shot) -> Picture | None:
    x, y = target.marks
    flat = _placed(rig, shot, np.hypot(x, y), np.arctan2(y, x))
    seen = _in_image(rig.camera, flat.points)
    if not seen.all():
        return None
    rows, beside, _ = _through_camera(rig, flat, np.broadcast_to(np.eye(2), (x.size, 2, 2)), seen)
    none = np.zeros((len(rows), 0))
    return Picture(rows / target.noise, beside / target.noise, np.full(6, np.inf), none, np.zeros(0), ())


def _placed(rig: Rig, shot: Shot, radius: Array, angle: Array) -> _Flat:
    """Points at polar places (n,) of the target: in its plane, x right and y down where it stands square."""
    camera, along = rig.camera, np.stack([np.cos(angle), np.sin(angle), np.zeros(angle.size)], axis=1)
    surface = rig.lasers[0].surface
    if shot.in_light and isinstance(surface, Plane):
        origin, normal = np.array([0.0, 0.0, surface.baseline]), surface.normal
    else:
        size = camera.width, camera.height
        u, v = ((1 + place) / 2 * side - 0.5 for place, side in zip(shot.place, size, strict=True))
        centred = shot.place == (0.0, 0.0)
        ray = np.array([0.0, 0.0, 1.0]) if centred else camera.unproject([u], [v]).direction[0]
        x, y = xy_of(shot.towards, np.sin(shot.tilt))
        origin, normal = (shot.distance or 0.0) * ray, np.array([-x, -y, np.cos(shot.tilt)])
    outwards = along @ np.stack(_axes(normal))
    return _Flat(origin + radius[:, None] * outwards, origin, outwards)


def _through_camera(rig: Rig, flat: _Flat, across: Array, kept: Array) -> tuple[Array, Array, Array]:
    """Rows (n k, p) by the rig, (n k, 6) by turn and shift of the target, (n, k, 3) by the points, of the coordinates
    `across` (n, k, 2) of the `kept` marks in the image.
    """
    found = rig.camera.project_with_sensitivities(flat.points[kept])
    by_point, by_camera = across[kept] @ found.by_point, across[kept] @ found.by_parameters
    arm = flat.points[kept] - flat.origin
    turned = np.cross(arm[:, None, :], by_point)
    rows = np.zeros((*by_camera.shape[:2], len(rig.parameter_names)))
    rows[:, :, -len(rig.camera.parameter_names) :] = by_camera
    beside = np.concatenate([turned, by_point], axis=2)
    return rows.reshape(-1, len(rig.parameter_names)), beside.reshape(-1, 6), by_point


def _with_light(rig: Rig, rows: Array, beside: Array) -> Array:
    """`rows` of a target that goes with the plane of light it stands in: it turns by n x dn, shifts by the baseline."""
    plane = rig.lasers[0].surface
    assert isinstance(plane, Plane)
    length = np.linalg.norm(plane.normal)
    normal = plane.normal / length
    tilts = np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    turns = np.cross(normal, (tilts - np.outer(tilts @ normal, normal)) / length)
    rows = rows.copy()
    for name, motion in zip(
        plane.parameter_names, [[0, 0, 0, 0, 0, 1.0], [*turns[0], 0, 0, 0], [*turns[1], 0, 0, 0]], strict=True
    ):
        rows[:, rig.parameter_names.index(f"{rig.laser_table(0)}.{name}")] += beside @ np.array(motion)
    return rows


def _along_plane(rig: Rig) -> Array:
    """(6, 6): turns and shifts of a target in the light as columns along, along and across its plane."""
    plane = rig.lasers[0].surface
    assert isinstance(plane, Plane)
    axes = np.column_stack(_axes(plane.normal))
    return np.block([[axes, np.zeros((3, 3))], [np.zeros((3, 3)), axes]])


def _axes(normal: Array) -> tuple[Array, Array, Array]:
    """Unit vectors along a plane, the first without y, and its unit normal."""
    normal = normal / np.linalg.norm(normal)
    first = np.array([normal[2], 0.0, -normal[0]]) / np.hypot(normal[0], normal[2])
    return first, np.cross(normal, first), normal


def _across(camera: Camera, ahead: Array, behind: Array) -> Array:
    """(n, 2) unit vectors across the image of a line from points `behind` to points `ahead`."""
    return across_line(np.stack(camera.project(ahead), axis=1) - np.stack(camera.project(behind), axis=1))


def _in_image(camera: Camera, points: Array) -> NDArray[np.bool_]:
    return in_picture(camera, *camera.project(points))

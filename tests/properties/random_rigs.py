"""Random rigs in random pipes, with and without pictures: for the tests, and for `python -m benchmarks`."""

from typing import NamedTuple

import numpy as np

from calibore.geometry import xy_of
from calibore.lasers import Beam, Sheet
from calibore.profiling import Job, measure_image
from calibore.rigs import SideFacing, margin, meetings_of, project_ring, triangulate
from calibore.simulation import (
    LineLight,
    Sensor,
    draw_rig,
    lit_line,
    photograph,
    random_pose,
    random_rig,
    random_wall,
    true_ring,
)
from calibore.uncertainty import propagate

NOMINAL = 0.15
U_PIXEL = 0.3
"""px, of a line's position; a shared error of the rigs' stated uncertainties is about as large."""
SEEN_POINTS = 8
"""Per laser and true rig: many true rigs tell more than many points."""
MOST_LASERS = 2
"""Of a rig whose lasers are all alike."""


def one_ring(seed, *, exact, features, kind="perpendicular-plane", laser=0):
    """(ring, truth, nominal radius) of one simulated picture, in which one laser is lit; the rig file is `exact` or a
    little wrong.
    """
    rng = np.random.default_rng([7, seed])
    wall = random_wall(rng, features=features)
    stated = random_rig(rng, wall.nominal_radius, kind=kind)
    rig = stated if exact else draw_rig(stated, rng)
    pose = random_pose(rng, stated, wall.nominal_radius)
    line = LineLight(sigma=wall.nominal_radius * rng.uniform(0.002, 0.006))
    sensor = Sensor(speckle_contrast=rng.uniform(0, 0.5), psf_sigma=rng.uniform(0.8, 1.5))
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=sensor.psf_sigma, laser=laser)
    image = photograph(lit, rig, line=line, sensor=sensor, rng=rng, speckle_rng=rng, laser=laser)
    truth = true_ring(lit, rig, wall, pipe_from_rig=pose, line=line, laser=laser)
    ring = measure_image(image, Job.of(stated, wall.nominal_radius), laser=laser)
    return ring, truth, wall.nominal_radius


class Detections(NamedTuple):
    """Simulated detections (n,): error and predicted standard uncertainty of radius and axial position [m], margin."""

    radius_error: np.ndarray
    radius_u: np.ndarray
    axial_error: np.ndarray
    axial_u: np.ndarray
    margin: np.ndarray


def detections(kind, seed, *, draws):
    """What a random rig of this kind, as its file states it, finds of walls 0.9 ... 1.1 nominal radii away, where
    `draws` true rigs behind it image them and the line is found with `U_PIXEL`.
    """
    rng = np.random.default_rng([11, seed])
    stated = random_rig(rng, NOMINAL, kind=kind)
    true = [draw_rig(stated, rng) for _ in range(draws)]
    parts = [_detected(stated, true, rng, laser) for laser in range(len(stated.lasers))[:MOST_LASERS]]
    return Detections(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _detected(stated, true, rng, laser):
    imaged = [_imaged(rig, rng, laser) for rig in true]
    u, v, radius, axial, branch = (np.concatenate(columns) for columns in zip(*imaged, strict=True))
    direction = stripe_direction(stated, u, v, laser)
    if direction is None:
        du, dv = U_PIXEL * rng.standard_normal((2, u.size))
    else:
        du, dv = U_PIXEL * rng.standard_normal(u.size) * direction.T
    found = triangulate(stated, u + du, v + dv, laser=laser, branch=branch)
    columns = []
    for error, by in (
        (found.radius - radius, found.radius_sensitivities),
        (found.axial - axial, found.axial_sensitivities),
    ):
        own = np.linalg.norm(by.pixel, axis=1) if direction is None else np.sum(by.pixel * direction, axis=1)
        common = propagate(by.parameters, stated.covariance, names=found.parameter_names).u
        columns += [error, np.hypot(U_PIXEL * own, common)]
    m = margin(stated, u + du, v + dv, branch=branch, u_pixel=U_PIXEL, direction=direction, laser=laser)
    return Detections(*columns, m)


def _imaged(rig, rng, laser):
    """Pixels u, v (n,) of lit points as `rig` images them, their radius, axial position and branch."""
    if isinstance(rig.mount, SideFacing):
        u, v = rng.uniform(0, 1, (2, SEEN_POINTS)) * np.array([[rig.camera.width - 1], [rig.camera.height - 1]])
        points = triangulate(rig, u, v).points
    else:
        points = wall_points(rig, rng, SEEN_POINTS, laser=laser)
        u, v = rig.project(points)
    away = meetings_of(rig, u, v, laser=laser).distance - np.linalg.norm(points - rig.mount.translation, axis=1)
    branch = np.argmin(np.where(np.isfinite(away), np.abs(away), np.inf), axis=0)
    return u, v, np.hypot(points[:, 0], points[:, 1]), points[:, 2], branch


def wall_points(rig, rng, n, *, laser=0):
    """Points (n, 3) [m] in the light of `laser`, on walls 0.9 ... 1.1 nominal radii from the rig axis; of a side-facing
    sheet, of what its camera sees.
    """
    radius, surface = NOMINAL * rng.uniform(0.9, 1.1, n), rig.lasers[laser].surface
    if isinstance(surface, Sheet):
        y, z = NOMINAL * rng.uniform(0.75, 1.3, n), NOMINAL * rng.uniform(-0.05, 0.05, n)
        return np.column_stack([surface.offset + surface.skew * y + surface.lean * z, y, z])
    if isinstance(surface, Beam):
        source, direction = surface.source, surface.direction
        square, along = direction[:2] @ direction[:2], source[:2] @ direction[:2]
        reach = (np.sqrt(along**2 + square * (radius**2 - source[:2] @ source[:2])) - along) / square
        return source + reach[:, None] * direction
    feet = np.column_stack([*xy_of(rng.uniform(0, 2 * np.pi, n), radius), np.zeros(n)])
    meetings = surface.meet(feet, np.tile([0.0, 0.0, 1.0], (n, 1)))
    feet[:, 2] = np.nanmin(np.where(meetings.admissible, meetings.distance, np.nan), axis=0)
    return feet


def stripe_direction(rig, u, v, laser):
    """Along which (n, 2) the line is looked for at the pixels `u`, `v`; None for a spot, found in u and in v."""
    if isinstance(rig.mount, SideFacing):
        return np.tile([1.0, 0.0], (u.size, 1))
    if isinstance(rig.lasers[laser].surface, Beam):
        return None
    _, ring_u, ring_v = project_ring(rig, NOMINAL, 72, laser=laser)
    outwards = np.stack([u - ring_u.mean(), v - ring_v.mean()], axis=1)
    return outwards / np.linalg.norm(outwards, axis=1, keepdims=True)

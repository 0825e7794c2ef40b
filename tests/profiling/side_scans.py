"""Side-facing surveys of simulated pipes, and what the wall truly is where their profiles say something."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import Pose, xy_of
from calibore.simulation import (
    LineLight,
    PipeWall,
    Sensor,
    Station,
    Survey,
    draw_rig,
    random_rig,
    random_wall,
    simulate_scan,
)

Array = NDArray[np.float64]
WIDTH, HEIGHT = 256, 192
THICKNESS = 0.0025
"""Of the light, over the nominal radius: some 2 px, as in a picture of full size."""
STEP = np.radians(0.9)
STRIP = 0.4
"""Nominal radii along the pipe that one picture shows, about."""


def side_survey(
    seed: int,
    *,
    angles: tuple[int, ...],
    stations: int = 1,
    takes: int = 1,
    wall: PipeWall | None = None,
    overlap: float = 0.6,
) -> Survey:
    """A head with stated uncertainty and true parameters drawn from it, off the axis of a pipe without features."""
    rng = np.random.default_rng(seed)
    drawn = random_wall(rng, features=False)
    wall = wall or drawn
    radius = wall.nominal_radius
    stated = random_rig(rng, radius, kind="side-facing", width=WIDTH, height=HEIGHT)
    true = draw_rig(stated, rng)
    shift = xy_of(rng.uniform(0, 2 * np.pi), 0.03 * radius * np.sqrt(rng.uniform()))
    stops = tuple(Station(n, takes=takes, angular=k) for n in range(stations) for k in angles)
    return Survey(
        "side-facing head",
        true,
        wall,
        stops,
        origin=-0.1 * radius,
        step=(1 - overlap) * STRIP * radius,
        pose=Pose.from_roll_pitch_yaw(translation=(float(shift[0]), float(shift[1]), 0.0)),
        line=LineLight(sigma=THICKNESS * radius),
        stated=stated,
        prefix="side",
        angular=(0.0, float(STEP)),
    )


def perfect(survey: Survey) -> Survey:
    """The same without noise, the rig exactly as its file says."""
    return replace(survey, rig=survey.stated or survey.rig, sensor=Sensor.perfect())


def scan_of(survey: Survey, folder: Path, *, seed: int = 1) -> Path:
    return simulate_scan(folder, survey, seed=seed)


def true_radius(survey: Survey, axial: Array, clock: Array, near: Array) -> Array:
    """(n,) [m] from the rig axis: where a ray from it at `axial` (n,), `clock` (n,) meets the wall, from `near` on."""
    x, y = xy_of(clock, 1.0)

    def depth(radius: Array) -> Array:
        return survey.wall.depth(survey.pose.apply(np.stack([radius * x, radius * y, axial], axis=-1)))

    radius, step = near.copy(), 1e-6
    for _ in range(6):
        radius = radius - depth(radius) * 2 * step / (depth(radius + step) - depth(radius - step))
    return radius

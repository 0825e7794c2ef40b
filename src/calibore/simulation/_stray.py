"""Light of a laser that reaches the picture by another way than straight from where it lit the wall."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose, clock_of
from calibore.rigs import Rig
from calibore.simulation._fan import Fan
from calibore.simulation._light import LitLine, Stray, inside_image, lambert
from calibore.simulation._sight import wall_normal
from calibore.simulation._wall import PipeWall
from calibore.simulation._water import Water, returned_share
from calibore.simulation._window import CLEAR, Window

Array = NDArray[np.float64]

WAVED = 6.0  # px, standard deviation beyond which waves spread no mirror image
GLINT = (2.0, 30.0)  # peaks of glints, of full scale: white in their middle
GLINT_LENGTH = 6.0  # px, standard deviation across the picture of the longest glint


def seen_through(
    lit: LitLine, rig: Rig, wall: PipeWall, *, pipe_from_rig: Pose, window: Window = CLEAR, laser: int = 0
) -> LitLine:
    """The line `lit` as the camera sees it through its `window`, with the stray light of water and window."""
    stray = [] if wall.water is None else _of_water(lit, rig, wall, wall.water, pipe_from_rig, laser)
    centre = rig.camera.principal_point
    stray += [ghost.of(light, centre) for ghost in window.ghosts for light in (lit, *stray)]
    if not stray and not window.smudges:
        return lit
    passed = window.passes(lit.u, lit.v)
    caught = tuple(replace(one, energy=_caught(one, rig) * window.passes(one.u, one.v)) for one in stray)
    leaves = tuple(replace(leaf, energy=leaf.energy * window.passes(leaf.u, leaf.v)) for leaf in lit.leaves)
    return replace(lit, energy=lit.energy * passed, signal=lit.signal * passed, stray=caught, leaves=leaves)


def _caught(stray: Stray, rig: Rig) -> Array:
    return np.where(inside_image(stray.u, stray.v, rig), stray.energy, 0.0)


def _of_water(lit: LitLine, rig: Rig, wall: PipeWall, water: Water, pose: Pose, laser: int) -> list[Stray]:
    eye, fan = pose.apply(rig.mount.translation), Fan.of(rig, pose, laser=laser)
    surface = water.surface(wall.nominal_radius)
    for what, place in (("camera", eye), ("laser", fan.source)):
        if place[1] >= surface:
            raise InputError(
                f"The {what} stands {place[1] - surface:.4g} m under water; lower the level of {water.level:g} m."
            )
    glints = [_glints(lit, rig, wall, water, fan)] if water.glints else []
    return [_mirror_image(lit, rig, wall, water, pose, eye), *glints]


def _mirror_image(lit: LitLine, rig: Rig, wall: PipeWall, water: Water, pose: Pose, eye: Array) -> Stray:
    """The lit wall that the camera sees directly, seen again in the surface. Waves of slope s tilt the reflected ray by
    2 s: they spread it up and down.
    """
    points, rig_from_pipe = pose.apply(lit.points), pose.inverse()
    image = water.mirrored(points, wall.nominal_radius)
    way = image - eye
    distance = np.linalg.norm(way, axis=1)
    way /= distance[:, None]
    before = (water.surface(wall.nominal_radius) - eye[1]) / np.maximum(way[:, 1], 1e-9)  # m to the surface
    shown = (lit.energy > 0) & (way[:, 1] > 0) & (before < distance)
    shown[shown] = wall.depth(eye + before[shown, None] * way[shown]) < 0
    u, v = rig.project(rig_from_pipe.apply(image))
    upright = np.array([0.0, 1.0, 0.0]) - way[:, 1:2] * way
    wave = 2 * water.ripple * (distance - before)[:, None] * upright
    beside = np.stack(rig.project(rig_from_pipe.apply(image + np.where(shown[:, None], wave, 0.0))), axis=1)
    spread = _widest(np.nan_to_num(beside - np.stack([u, v], axis=1)), lit.spread)
    normal = wall_normal(wall, points, clock_of(points[:, 0], points[:, 1]))
    straight = lambert(points, normal, eye)
    turned = lambert(points, normal, water.mirrored(eye, wall.nominal_radius))
    share = np.divide(turned, straight, out=np.zeros_like(straight), where=straight > 0)
    energy = np.where(shown, lit.energy * share * returned_share(np.clip(way[:, 1], 0.0, 1.0)), 0.0)
    return Stray(u, v, spread, energy)


def _widest(one: Array, other: Array) -> Array:
    """The longer (n, 2) of two spreads [px]; one of several pixels, that of waves, hides the other."""
    length, thickness = np.linalg.norm(one, axis=1), np.linalg.norm(other, axis=1)
    shorter = one * np.minimum(1.0, WAVED / np.maximum(length, 1e-9))[:, None]
    return np.where((length > thickness)[:, None], shorter, other)


def _glints(lit: LitLine, rig: Rig, wall: PipeWall, water: Water, fan: Fan) -> Stray:
    """Where the light meets the surface, here and there a wave sends it into the camera. The same stop, the same."""
    pipe_points = fan.rig_from_pipe.inverse().apply(lit.points)
    under = np.flatnonzero(water.covers(pipe_points, wall.nominal_radius))
    place = np.abs(np.rint(1e6 * fan.source)).astype(np.int64)  # um
    rng = np.random.default_rng([water.seed, *place.tolist()])
    count = int(rng.poisson(water.glints)) if under.size else 0
    chosen = rng.choice(under, count) if count else under[:0]
    drop = pipe_points[chosen] - fan.source
    height = (water.surface(wall.nominal_radius) - fan.source[1]) / drop[:, 1]
    u, v = rig.project(fan.rig_from_pipe.apply(fan.source + height[:, None] * drop))
    length, peak = rng.uniform(0.0, GLINT_LENGTH, count), rng.uniform(*GLINT, count)
    spread = np.column_stack([length, np.zeros(count)])
    return Stray(u, v, spread, peak * 2 * np.pi * np.hypot(1.0, length))

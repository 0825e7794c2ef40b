"""Two cameras compared by where they see what: differences of directions in pixels, less a turn of the whole camera."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._difference._sides import Side, alike
from calibore.calibration._difference._test import Evidence, Judgement, judged
from calibore.calibration._projection import (
    Implied,
    ProjectionUncertainty,
    image_grid,
    implied_turns,
    projection_slopes,
    turns_against,
    uncertainty_of,
)
from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import ValidRegion

Array = NDArray[Any]
STEPS, SETTLED = 8, 1e-12
ROWS = 16
"""Of the grid of pixels compared: differences of smooth lenses hide nothing between them."""
BENDING = 1 / 50
"""1/px: pixels over which a lens's image changes its scale noticeably, pessimistically; limits what first order tells
of lenses whose parameters cannot be compared one by one."""


@dataclass(frozen=True, eq=False)
class DirectionDifference:
    """At pixels `u`, `v` (n,) of the first camera: where the second images the same direction, less that pixel, as
    `difference` (n, 2) [px] with its `uncertainty`, after the `turn` (3,) [rad] of the second about its axes was taken
    out. `rms` and what the covariances let expect, `expected` [px].
    """

    u: Array
    v: Array
    difference: Array
    uncertainty: ProjectionUncertainty
    turn: Array
    rms: float
    expected: float
    judgement: Judgement


def compare_directions(a: Side, b: Side) -> tuple[DirectionDifference, Evidence]:
    """Over the pixels that both see within their valid regions."""
    _check_images(a.camera, b.camera)
    u, v = _shared_grid(a, b)
    slopes, turns = zip(*(projection_slopes(one.camera, u, v) for one in (a, b)), strict=True)
    if alike(a, b):
        slopes = ((slopes[0] + slopes[1]) / 2,) * 2
    motions = [_motions(slope, one) for slope, one in zip(slopes, (a, b), strict=True)]
    implied = implied_turns(np.concatenate(motions, axis=2), turns[1])
    rotation, difference = _turned(a.camera, b.camera, (u, v), turns[1], implied)
    first, second = (one + turns[1] @ turns_against(one, turns[1], implied.weights) for one in motions)
    linear = _linear(a, b, slopes[0], turns[1], implied) if alike(a, b) else difference
    count = u.size
    evidence = Evidence(
        difference.ravel(),
        linear.ravel(),
        first.reshape(2 * count, -1),
        second.reshape(2 * count, -1),
        (a.degrees_of_freedom, b.degrees_of_freedom),
    )
    found = DirectionDifference(
        u,
        v,
        difference,
        uncertainty_of(np.concatenate([first, second], axis=2)),
        rotation,
        float(np.sqrt((difference**2).sum() / count)),
        float(np.sqrt(2) * evidence.expected),
        judged(evidence, curvature=0.0 if alike(a, b) else BENDING),
    )
    return found, evidence


def turn_between(first: Array, second: Array, weights: Array) -> Array:
    """The rotation (3, 3) that turns directions `first` (n, 3) best into `second` (Kabsch 1976)."""
    left, _, right = np.linalg.svd((second * weights[:, None]).T @ first)
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right


def _turned(a: Camera, b: Camera, pixels: tuple[Array, Array], turns: Array, implied: Implied) -> tuple[Array, Array]:
    """The turn (3,) [rad], and the difference (n, 2) [px] after it: Gauss-Newton from the best turn of directions."""
    directions = a.unproject(*pixels).direction
    rotation = turn_between(directions, b.unproject(*pixels).direction, implied.weights)
    for _ in range(STEPS):
        difference = np.stack(b.project(directions @ rotation.T), axis=1) - np.stack(pixels, axis=1)
        there = np.isfinite(difference[:, 0])
        step = turns_against(difference[there, :, None], turns[there], implied.weights[there])[:, 0]
        rotation = _rotation(step) @ rotation
        if np.abs(step).max() < SETTLED:
            break
    difference = np.stack(b.project(directions @ rotation.T), axis=1) - np.stack(pixels, axis=1)
    return _vector(rotation), np.where(np.isfinite(difference), difference, 0.0)


def _linear(a: Side, b: Side, slopes: Array, turns: Array, implied: Implied) -> Array:
    change = np.array([b.values[name] - a.values[name] for name in a.camera.parameter_names])
    moved = (slopes @ change)[:, :, None]
    return (moved + turns @ turns_against(moved, turns, implied.weights))[:, :, 0]


def _motions(slopes: Array, one: Side) -> Array:
    """(n, 2, m) [px] by unit draws; all parameters of a rig draw together, of which the camera's move directions."""
    names = one.camera.parameter_names
    rows = [one.covariance.names.index(name) if name in one.covariance.names else -1 for name in names]
    factor = np.vstack([one.covariance.factor(), np.zeros((1, len(one.covariance.names)))])
    return slopes @ factor[rows]


def _shared_grid(a: Side, b: Side) -> tuple[Array, Array]:
    zeniths = [one.valid.zenith for one in (a, b) if one.valid is not None and one.valid.zenith is not None]
    low, high = max((z[0] for z in zeniths), default=0.0), min((z[1] for z in zeniths), default=np.pi)
    if low >= high:
        raise InputError(
            "The valid regions of the two calibrations do not overlap, so they cannot be compared; photograph the "
            "target over the same part of the image."
        )
    valid = ValidRegion(zenith=(low, high)) if zeniths else None
    u, v = image_grid(a.camera, rows=ROWS, valid=valid)
    seen = np.isfinite(b.camera.unproject(u, v).direction[:, 2])
    return u[seen], v[seen]


def _check_images(a: Camera, b: Camera) -> None:
    if (a.width, a.height) != (b.width, b.height):
        raise InputError(
            f"The images differ in size, {a.width} x {a.height} px and {b.width} x {b.height} px, so pixels cannot be "
            "compared; calibrate both in the same image format."
        )


def _rotation(vector: Array) -> Array:
    """About `vector` by its length (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    half = np.sinc(angle / (2 * np.pi))
    return np.eye(3) + np.sinc(angle / np.pi) * cross + half**2 / 2 * cross @ cross


def _vector(rotation: Array) -> Array:
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    sine = float(np.linalg.norm(skew)) / 2
    angle = np.arctan2(sine, (np.trace(rotation) - 1) / 2)
    return skew / 2 * (angle / sine if sine > 0 else 1.0)

"""The place of a dot: the centroid of its darkness, background taken away; linear in the grey values, so noise adds no
bias. It is the image of the dot's area, not of its centre: whoever knows the lens corrects for that.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.targets._boards import Board
from calibore.targets._boards_lattice import Lattice

Array = NDArray[np.float64]

NEAREST = 7  # marks, itself included, that tell the local scale
ROOM = {"circle-grid": 0.5, "asymmetric-circle-grid": 0.7}  # pitches: half the way to the next dot
LARGEST = 60  # px, half side of a window
LEAST_AREA = 12.0  # px of a dot whose centroid means anything
WIDTHS = 3.5  # blurs from its edge at which a dot ends
STEPS = 3


class Dots(NamedTuple):
    """Places (n, 2) [px], NaN where there is none; standard uncertainty `sigma` (n,) [px] of each coordinate by noise;
    `blur` (n,) [px]; `diameter` (n,) in pitches.
    """

    places: Array
    sigma: Array
    blur: Array
    diameter: Array


def measured_dots(image: Array, rough: Array, board: Board) -> Dots:
    """Dots near the places `rough` (n, 2) [px] of `image` (h, w)."""
    lattice = _local_scale(rough, board)
    rows = [_measured(image, place, *steps, board) for place, *steps in zip(rough, *lattice[:2], strict=True)]
    u, v, sigma, blur, diameter = np.array(rows).T
    return Dots(np.stack([u, v], axis=1), sigma, blur, diameter)


def _local_scale(rough: Array, board: Board) -> Lattice:
    """Steps along and down at each mark from an affine map of the nearest marks."""
    distance = np.linalg.norm(board.places[:, None] - board.places[None], axis=2)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :NEAREST]
    offsets = board.places[nearest] - board.places[:, None]
    design = np.concatenate([offsets, np.ones((*nearest.shape, 1))], axis=2)
    steps = np.linalg.pinv(design) @ rough[nearest]
    none = np.zeros_like(rough)
    return Lattice(steps[:, 0], steps[:, 1], none, none)


def _measured(image: Array, place: Array, along: Array, down: Array, board: Board) -> tuple[float, ...]:
    """u, v, sigma, blur [px] and diameter [pitches] of one dot; NaN where it cannot be measured."""
    room = ROOM[board.kind]
    half = int(np.ceil(room * max(np.linalg.norm(along), np.linalg.norm(down)))) + 1
    inverse = np.linalg.inv(np.stack([along, down], axis=1))
    area_of_pitch = abs(np.linalg.det(np.stack([along, down], axis=1)))
    missing = (np.nan,) * 5
    found, reach = missing, room
    shortest = min(np.linalg.norm(along), np.linalg.norm(down))
    for _ in range(STEPS):
        origin = np.rint(place).astype(int)
        low, high = origin - half, origin + half + 1
        if half > LARGEST or (low < 0).any() or (high > image.shape[::-1]).any():
            return missing
        grey = image[low[1] : high[1], low[0] : high[0]].astype(float)
        y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
        offset = np.stack([x - place[0], y - place[1]]).reshape(2, -1)
        distance = np.hypot(*(inverse @ offset))
        found = _centroid(grey, offset, distance, (reach, room), area_of_pitch)
        if not np.isfinite(found[0]):
            return missing
        place = place + np.array(found[:2])
        reach = min(room, found[4] / 2 + WIDTHS * found[3] / shortest)
    return (*place.tolist(), *found[2:])


def _centroid(
    grey: Array, offset: Array, distance: Array, rooms: tuple[float, float], area_of_pitch: float
) -> tuple[float, ...]:
    """Offsets, sigma, blur [px], diameter [pitches]; `rooms` of the dot and of paper round it [pitches]."""
    values = grey.ravel()
    reach, room = rooms
    inside, rim = distance < reach, (distance >= 0.85 * room) & (distance < 1.1 * room)
    plane, *_ = np.linalg.lstsq(_with_ones(offset[:, rim]), values[rim], rcond=None)
    noise = float(np.std(values[rim] - _with_ones(offset[:, rim]) @ plane))
    darkness = _with_ones(offset) @ plane - values
    contrast = float(np.percentile(darkness[inside], 98))
    weight = float(darkness[inside].sum())
    area = weight / max(contrast, 1e-9)
    if contrast < 4 * noise or area < LEAST_AREA:
        return (np.nan,) * 5
    du, dv = (float(darkness[inside] @ part[inside]) / weight for part in offset)
    spread = float(np.sqrt(np.mean(np.sum(offset[:, inside] ** 2, axis=0)) / 2 * inside.sum()))
    steepest = float(np.percentile(np.hypot(*np.gradient(grey)).ravel()[inside], 98))
    blur = np.sqrt(
        max((contrast / (np.sqrt(2 * np.pi) * steepest)) ** 2 - 1 / 3, 0.01)
    )  # 1/3: of the difference itself
    return du, dv, noise * spread / weight, float(blur), float(2 * np.sqrt(area / area_of_pitch / np.pi))


def _with_ones(offset: Array) -> Array:
    return np.column_stack([offset.T, np.ones(offset.shape[1])])

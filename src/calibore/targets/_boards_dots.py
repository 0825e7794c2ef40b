"""The place of a dot: the centroid of its darkness against the paper, which is linear in its grey values.

It is the image of the dot's area, not of its centre: whoever knows the lens corrects for that.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.targets._boards import Board

Array = NDArray[np.float64]

NEAREST = 7  # marks, itself included, that tell the local scale
ROOM = {"circle-grid": 0.5, "asymmetric-circle-grid": 0.7}  # pitches: half the way to the next dot
LARGEST = 60  # px, half side of a window
LEAST_AREA = 12.0  # px of a dot whose centroid means anything
WIDTHS = 3.5  # blurs from its edge at which a dot ends
RIM = 0.85, 1.1  # of the room: paper
PEAK = 98.0  # percentile that stands for the darkest or steepest pixel
CLEAR = 4.0  # standard deviations of noise
OF_DIFFERENCE = 1 / 3  # px^2, variance of the central difference that takes the slope
LEAST_BLUR = 0.1  # px
STEPS = 3
MISSING = (np.nan,) * 5


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
    steps = _local_scale(rough, board)
    rows = [_measured(image, place, step, ROOM[board.kind]) for place, step in zip(rough, steps, strict=True)]
    u, v, sigma, blur, diameter = np.array(rows).T
    return Dots(np.stack([u, v], axis=1), sigma, blur, diameter)


def _local_scale(rough: Array, board: Board) -> Array:
    """Steps (n, 2, 2) [px] of the image per pitch, along x and along y, from an affine map of the nearest marks."""
    distance = np.linalg.norm(board.places[:, None] - board.places[None], axis=2)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :NEAREST]
    offsets = board.places[nearest] - board.places[:, None]
    design = np.concatenate([offsets, np.ones((*nearest.shape, 1))], axis=2)
    return (np.linalg.pinv(design) @ rough[nearest])[:, :2]


def _measured(image: Array, place: Array, step: Array, room: float) -> tuple[float, ...]:
    """u, v, sigma, blur [px] and diameter [pitches] of one dot; NaN where it cannot be measured."""
    lengths = np.linalg.norm(step, axis=1)
    half = int(np.ceil(room * lengths.max())) + 1
    found, reach = MISSING, room
    for _ in range(STEPS):
        low, high = np.rint(place).astype(int) - half, np.rint(place).astype(int) + half + 1
        if half > LARGEST or (low < 0).any() or (high > image.shape[::-1]).any():
            return MISSING
        y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
        offset = np.stack([x - place[0], y - place[1]])
        grey = image[low[1] : high[1], low[0] : high[0]].astype(float)
        found = _centroid(grey, offset, step, (reach, room))
        if not np.isfinite(found[0]):
            return MISSING
        place = place + np.array(found[:2])
        reach = min(room, found[4] / 2 + WIDTHS * found[3] / float(lengths.min()))
    return (float(place[0]), float(place[1]), *found[2:])


def _centroid(grey: Array, offset: Array, step: Array, rooms: tuple[float, float]) -> tuple[float, ...]:
    """Offset, sigma, blur [px], diameter [pitches]; `rooms` of the dot and of paper round it [pitches]."""
    distance = np.hypot(*np.linalg.solve(step.T, offset.reshape(2, -1))).reshape(grey.shape)
    reach, room = rooms
    inside, rim = distance < reach, (distance >= RIM[0] * room) & (distance < RIM[1] * room)
    terms = np.stack([*offset, np.ones(grey.shape)], axis=2)
    paper = terms @ np.linalg.lstsq(terms[rim], grey[rim], rcond=None)[0]
    if not paper.min() > 0:
        return MISSING
    darkness = 1 - grey / paper  # of the paper's own light, which may fall off across the dot
    noise, contrast, weight = np.std(darkness[rim]), np.percentile(darkness[inside], PEAK), darkness[inside].sum()
    area = weight / max(contrast, 1e-9)
    if contrast < CLEAR * noise or area < LEAST_AREA:
        return MISSING
    du, dv = (float(darkness[inside] @ part[inside] / weight) for part in offset)
    square = np.sum(offset**2, axis=0) / 2
    slope = (
        np.sum(square * (1 - darkness), where=inside) ** 2 / square[rim].sum()
    )  # of the paper: it moves what is white
    spread = np.sqrt(square[inside].sum() + slope)
    diameter = 2 * np.sqrt(area / abs(np.linalg.det(step)) / np.pi)
    return du, dv, float(noise * spread / weight), _blur(darkness, inside, float(contrast)), float(diameter)


def _blur(darkness: Array, inside: NDArray[np.bool_], contrast: float) -> float:
    """Standard deviation [px] of the blur of an edge whose steepest slope is that of a Gaussian's integral."""
    slope = np.hypot(np.asarray(np.gradient(darkness, axis=0)), np.asarray(np.gradient(darkness, axis=1)))
    width = contrast / (np.sqrt(2 * np.pi) * float(np.percentile(slope[inside], PEAK)))
    return float(np.sqrt(max(width**2 - OF_DIFFERENCE, LEAST_BLUR**2)))

"""Does it fit: a stiff body that turns from a manhole's shaft into the pipe (Swanbom 2007, figure 4.7)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from calibore.design._occlusion import source_of
from calibore.errors import InputError
from calibore.rigs import Rig

TURNS = 4000
"""Steps of the coarse search over the angle of the body; golden section then finds the minimum between two of them."""


@dataclass(frozen=True)
class Deployment:
    """A body of `length` x `height` [m] through a shaft of diameter `manhole` into a pipe of `pipe` [m]; `longest`
    body of that height that passes; `rig_length`: camera to the farthest laser; `fits`.
    """

    manhole: float
    pipe: float
    height: float
    rig_length: float
    body_length: float
    length: float
    longest: float
    fits: bool


def longest_body(manhole: float, pipe: float, height: float) -> float:
    """Length [m] of the longest stiff body of `height` that turns from the shaft into the pipe; 0 where none enters.

    In the plane of both axes: the ladder round the corner with a thickness. At the angle t from the pipe its underside
    touches floor and shaft and its top must clear the edge: L sin t cos t <= M sin t + P cos t - h. A body no longer
    than the shaft is wide goes down level; one that stands in the pipe may be laid down in it.
    """
    _check(manhole, pipe, height)
    if height > min(manhole, pipe):
        return 0.0
    level = manhole
    standing = float(np.sqrt(max(pipe**2 - height**2, 0.0)))
    return max(_turning(manhole, pipe, height), level, standing)


def deployment(
    rig: Rig, *, nominal_radius: float, manhole: float, body_length: float, body_height: float
) -> Deployment:
    """Whether the rig on a crawler of `body_length` x `body_height` [m] passes a manhole of diameter `manhole` [m]."""
    if not 0 <= body_length < np.inf:
        raise InputError(f"The body length must be 0 or more, got {body_length} m; it is the crawler without the rig.")
    reach = rig_length(rig)
    longest = longest_body(manhole, 2 * nominal_radius, body_height)
    length = reach + body_length
    return Deployment(
        manhole, 2 * nominal_radius, body_height, reach, body_length, length, longest, fits=length <= longest
    )


def rig_length(rig: Rig) -> float:
    """Axial extent [m] of pupil and lasers."""
    places = [float(rig.mount.translation[2]), *(float(source_of(laser.surface)[2]) for laser in rig.lasers)]
    return max(places) - min(places)


def _turning(manhole: float, pipe: float, height: float) -> float:
    angle = np.linspace(0, np.pi / 2, TURNS + 2)[1:-1]
    lowest = int(np.argmin(_length_at(angle, manhole, pipe, height)))
    low, high = angle[max(lowest - 1, 0)], angle[min(lowest + 1, TURNS - 1)]
    golden = (np.sqrt(5) - 1) / 2
    for _ in range(60):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if _length_at(left, manhole, pipe, height) < _length_at(right, manhole, pipe, height):
            high = right
        else:
            low = left
    return max(float(_length_at((low + high) / 2, manhole, pipe, height)), 0.0)


def _length_at(angle: Any, manhole: float, pipe: float, height: float) -> Any:
    sine, cosine = np.sin(angle), np.cos(angle)
    return (manhole * sine + pipe * cosine - height) / (sine * cosine)


def _check(manhole: float, pipe: float, height: float) -> None:
    for name, value in (("manhole", manhole), ("pipe", pipe), ("body height", height)):
        if not 0 < value < np.inf:
            raise InputError(f"The {name} must have a positive size, got {value} m; give its diameter or height.")

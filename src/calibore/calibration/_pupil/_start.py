"""Where a search for the pupil starts, and whether the pictures can tell it: straight lines through mean columns.

For small turns t, with e = pupil - slide: u = u0 - k t (1 + e / z) for a pin at distance z.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._pupil._model import PinModel, Sightings
from calibore.errors import InputError

Array = NDArray[np.float64]

LEAST_TURN = np.radians(0.5)
"""Turntable angles closer together than this count as one."""
LEAST_SLIDE = 0.2e-3
"""m; so do slide readings."""
LEAST_PARALLAX = 3.0
"""Standard deviations of the difference between the pins' motions that fix a pupil."""


class Start(NamedTuple):
    """Rough `values` for `PinModel.names`; the sense in which the scales of slide and turntable count."""

    values: Array
    forwards: int
    rightwards: int


def start_values(model: PinModel, seen: Sightings) -> Start:
    """Raises InputError where angles or slides are too few, the pins too near each other or interchanged."""
    _check_variety(model, seen)
    rows = [(near, *_mean_of(seen, number, near)) for number in np.unique(seen.picture) for near in (True, False)]
    near, u, turn, slide = (np.array(column) for column in zip(*rows, strict=True))
    middle = model.slides[slide.astype(int)].mean()
    reading = model.slides[slide.astype(int)] - middle
    near = near.astype(bool)
    (far_line, u_far), (near_line, u_near) = (_line(turn[pin], reading[pin], u[pin]) for pin in (~near, near))
    parallax, doubt = near_line[2] - far_line[2], np.hypot(u_far, u_near)
    forwards = 1 if (near_line[2] + far_line[2]) * -far_line[1] > 0 else -1
    rightwards = 1 if far_line[1] < 0 else -1
    _check_parallax(parallax * forwards * rightwards, float(doubt))
    pupil = -(near_line[1] - far_line[1]) / parallax
    k = rightwards * -(far_line[1] + pupil * far_line[2])
    distances = [abs(k) / max(abs(line[2]), abs(parallax) / 20) for line in (near_line, far_line)]
    aside = [
        (line[0] - (model.width - 1) / 2) / abs(k) * z for line, z in zip((near_line, far_line), distances, strict=True)
    ]
    pins = [value for x, z in zip(aside, distances, strict=True) for value in (x, z, 0.0, 0.0)]
    return Start(np.array([middle + pupil, abs(k), 0.0, 0.0, 0.0, 0.0, *pins, *model.slides]), forwards, rightwards)


def _mean_of(seen: Sightings, number: int, near: bool) -> tuple[float, float, int]:
    mine = (seen.picture == number) & (seen.near == near)
    return float(seen.u[mine].mean()), float(seen.turn[mine][0]), int(seen.slide[mine][0])


def _line(turn: Array, reading: Array, u: Array) -> tuple[Array, float]:
    """Line u = a + b t + c t s: (a, b, c) and the standard deviation of c."""
    design = np.stack([np.ones_like(turn), turn, turn * reading], axis=1)
    found = np.asarray(np.linalg.lstsq(design, u, rcond=None)[0], dtype=float)
    off = u - design @ found
    spread = np.sqrt(off @ off / max(u.size - 3, 1))
    return found, float(spread * np.sqrt(np.linalg.pinv(design.T @ design)[2, 2]))


def _check_variety(model: PinModel, seen: Sightings) -> None:
    turns = {int(slide): np.ptp(seen.turn[seen.slide == slide]) for slide in np.unique(seen.slide)}
    turned = [slide for slide, span in turns.items() if span > LEAST_TURN]
    if not turned:
        raise InputError(
            "All usable pictures were taken at one turntable angle, so nothing moves; photograph both pins at both "
            "ends of the camera's field of view, at every slide reading."
        )
    if np.ptp(model.slides[turned]) < LEAST_SLIDE:
        raise InputError(
            "All usable pictures were taken at one slide reading, so there is no length to measure by; move the slide "
            "by some millimetres and photograph both pins at the same turntable angles again."
        )


def _check_parallax(parallax: float, doubt: float) -> None:
    if abs(parallax) <= LEAST_PARALLAX * doubt:
        raise InputError(
            "Near and far pin move alike at every slide reading, so they cannot tell where the pupil is; set one pin "
            "much nearer to the camera than the other, and the slide readings further apart."
        )
    if parallax < 0:
        raise InputError(
            "The pin named as the near one moves as the farther of the two; interchange near_pin and far_pin."
        )

"""The measured wall seen from the pipe's own centre, and clock positions as people write them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.plotting._figures import COVERAGE_FACTOR
from calibore.plotting._stations import Floats

HOURS = 12
CLOCK_TICKS = ((-np.pi, "6 h"), (-np.pi / 2, "9 h"), (0.0, "12 h"), (np.pi / 2, "3 h"), (np.pi, "6 h"))


@dataclass(frozen=True)
class Wall:
    """Wall points about the fitted centre: `x`, `y`, `radius`, `U` (station, clock) [m], `clock` (clock,) [rad].

    `clock` is the position seen from the rig axis, as in the profile itself; `centred` is False where no centre is
    known and the rig axis stands in for it. `U` is the expanded uncertainty (k = 2) of one point.
    """

    x: Floats
    y: Floats
    radius: Floats
    U: Floats
    clock: Floats
    centred: bool

    @property
    def origin(self) -> str:
        return "fitted centre of each ring" if self.centred else "rig axis"


def wall_of(dataset: Any, rings: Any) -> Wall:
    """The wall of a profile `dataset` (station, clock); centres from it, else from `rings`, else the rig axis."""
    radius = np.asarray(dataset["radius"].values, float)
    if radius.ndim != 2 or radius.size == 0:
        raise InputError(f"A profile needs stations and clock positions, got shape {radius.shape}.")
    clock = np.asarray(dataset["clock"].values, float)
    centre_x, centre_y = _centres(dataset, rings, len(radius))
    centred = bool(np.any(np.isfinite(centre_x)))
    x, y = xy_of(clock, radius)
    if centred:
        x, y = x - centre_x[:, None], y - centre_y[:, None]
    expanded = COVERAGE_FACTOR * np.hypot(dataset["u_independent"].values, dataset["u_common"].values)
    return Wall(x, y, np.hypot(x, y), np.where(np.isfinite(radius), expanded, np.nan), clock, centred)


def _centres(dataset: Any, rings: Any, count: int) -> tuple[Floats, Floats]:
    if "centre_x" in dataset and "centre_y" in dataset:
        return np.asarray(dataset["centre_x"].values, float), np.asarray(dataset["centre_y"].values, float)
    x, y = np.full(count, np.nan), np.full(count, np.nan)
    if "centre_x_m" in rings and "centre_y_m" in rings:
        _, here, there = np.intersect1d(dataset["station"].values, rings["station"], return_indices=True)
        x[here], y[here] = np.asarray(rings["centre_x_m"], float)[there], np.asarray(rings["centre_y_m"], float)[there]
    return x, y


def centred_clock(clock: Floats) -> Floats:
    """Clock positions [rad] in -pi..pi: the crown in the middle, 9 h at -pi/2, 3 h at +pi/2."""
    return np.mod(np.asarray(clock, float) + np.pi, 2 * np.pi) - np.pi


def clock_text(clock: float) -> str:
    """`0.0` -> "12:00 h", `pi / 2` -> "3:00 h": the clock position [rad] as people read it."""
    if not np.isfinite(clock):
        return "unknown"
    minutes = round(float(np.mod(clock, 2 * np.pi)) / (2 * np.pi) * HOURS * 60) % (HOURS * 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours or HOURS}:{minutes:02d} h"

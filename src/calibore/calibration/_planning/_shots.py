"""Pictures that could be taken next."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._planning._targets import (
    PlannedBoard,
    PlannedFlats,
    PlannedGauges,
    PlannedRings,
    PlannedTarget,
)
from calibore.lasers import Plane
from calibore.rigs import Rig, SideFacing

Array = NDArray[Any]
UNITS = {"mm": 1e-3, "in": 0.0254}
SIDES = ("top", "right", "bottom", "left")
RING_DISTANCES = (0.3, 0.45, 0.65, 0.9, 1.3, 2.0)
"""In radii of the outermost ring: from 73 to 27 deg off the axis."""
RING_TILTS = tuple(np.radians([0.0, 10.0, 20.0]))
"""Rings must be seen round their centre to be told apart."""
BOARD_DISTANCES = (0.35, 0.6, 1.0, 1.7)
"""In diagonals of the board."""
BOARD_TILTS = tuple(np.radians([0.0, 30.0]))
ACROSS = (-0.6, 0.0, 0.6)
"""Places of a board's middle, in half image sizes."""
FLATS = 24
"""Stops considered, evenly over those on a slide."""


@dataclass(frozen=True)
class Shot:
    """One picture: of a flat target at `distance` [m] from the pupil, its side `towards` (clock, rad) leaning away from
    the camera by `tilt` [rad], its middle seen at `place` (fractions of half the image, from its middle); or standing
    `in_light`; or of the gauge of `diameter` [m]; or with a flat at `distance`, `straight` ahead of the light.
    """

    distance: float | None = None
    tilt: float = 0.0
    towards: float = 0.0
    place: tuple[float, float] = (0.0, 0.0)
    diameter: float | None = None
    in_light: bool = False
    straight: bool = False

    def said(self, unit: str = "mm") -> str:
        """What to set up, lengths in "mm" or "in"."""
        if self.in_light:
            return "standing in the light of the laser"
        if self.diameter is not None:
            return f"gauge of {self.diameter / UNITS[unit]:.4g} {unit}"
        text = f"at {(self.distance or 0.0) / UNITS[unit]:.3g} {unit}"
        if self.tilt:
            side = SIDES[round(self.towards / (np.pi / 2)) % 4]
            text += f", its {side} leaning {np.degrees(self.tilt):.0f} deg away"
        return text + ("" if self.straight else _place_text(self.place))


def usual_shots(rig: Rig, target: PlannedTarget, nominal_radius: float) -> Iterator[Shot]:
    """A round choice for this rig and target; those that the camera does not see are dropped later."""
    if isinstance(target, PlannedGauges):
        yield from (Shot(diameter=diameter) for diameter in target.diameters)
    elif isinstance(target, PlannedFlats):
        low, high = (0.2, 3.0) if isinstance(rig.mount, SideFacing) else (0.05, 5.0)
        there = [d for d in target.distances if low * nominal_radius <= d <= high * nominal_radius]
        yield from (Shot(distance=d, straight=True) for d in there[:: max(1, -(-len(there) // FLATS))])
    elif isinstance(target, PlannedRings):
        if isinstance(rig.lasers[0].surface, Plane):
            yield Shot(in_light=True)
        for distance in target.radii[-1] * np.array(RING_DISTANCES):
            yield from _tilted(float(distance), RING_TILTS, (0.0, 0.0))
    else:
        yield from _boards(target)


def _boards(target: PlannedBoard) -> Iterator[Shot]:
    for distance in target.diagonal * np.array(BOARD_DISTANCES):
        for across in ACROSS:
            for along in ACROSS:
                yield from _tilted(float(distance), BOARD_TILTS, (across, along))


def _tilted(distance: float, tilts: tuple[float, ...], place: tuple[float, float]) -> Iterator[Shot]:
    for tilt in tilts:
        for towards in (0.0, *(np.pi / 2 * np.arange(1, 4))) if tilt else (0.0,):
            yield Shot(distance, float(tilt), float(towards), place)


def _place_text(place: tuple[float, float]) -> str:
    words = [
        word
        for value, low, high in ((place[1], "top", "bottom"), (place[0], "left", "right"))
        for word in ((low,) if value < 0 else (high,) if value > 0 else ())
    ]
    return f", {' '.join(words)} of the image" if words else ", mid-image"

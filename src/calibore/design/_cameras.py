"""Cameras that see a given zenith at the edge of the image."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from calibore.errors import InputError
from calibore.optics import Camera, Lens

Axis = Literal["long", "short", "u"]


@dataclass(frozen=True)
class Imager:
    """The image and the lens law of a camera to be designed; its scale k follows from what it must see."""

    width: int = 1024
    height: int = 768
    lens: str = "equidistant"

    def seeing(self, half_angle: float, *, across: Axis) -> Camera:
        """The camera that sees `half_angle` [rad] at the edge of the image, across its long or short axis or u."""
        sides = {"long": max(self.width, self.height), "short": min(self.width, self.height), "u": self.width}
        unit = Lens(self.lens, 1.0, self.height / 2)
        reach = float(unit.image_radius(half_angle))
        if not reach > 0:
            raise InputError(
                f"A {self.lens} lens does not image a zenith of {np.degrees(half_angle):.4g} deg, only below "
                f"{np.degrees(unit.max_zenith):.4g} deg; choose another lens law or a rig that asks for less."
            )
        lens = Lens(self.lens, sides[across] / 2 / reach, self.height / 2)
        return Camera(self.width, self.height, lens, (self.width / 2, self.height / 2))


def checked(value: float, name: str, *, above: float = 0.0, below: float = np.inf, hint: str) -> float:
    """`value` if it lies between, else InputError with `hint` on what to do."""
    if not above < value < below:
        limits = f"above {above:g}" + (f" and below {below:g}" if below < np.inf else "")
        raise InputError(f"The {name} must be {limits} nominal radii, got {value:g}; {hint}.")
    return float(value)

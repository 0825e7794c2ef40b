"""Photographs of two pins from a camera that slides and turns: they tell where its entrance pupil is."""

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from calibore.errors import InputError
from calibore.optics import Camera
from calibore.simulation._pin_target import Pin, photograph_pins, turntable_pose
from calibore.simulation._sensor import Sensor
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres, radians

SLIDE = 0.0005 * 0.0254
"""m; a dial caliper with a depth probe, as the dissertation's (Swanbom 2007, 8.2.3)."""
TURN = float(np.radians(0.05))
"""rad; a turntable with a vernier."""


@dataclass(frozen=True, eq=False)
class PinTarget(Target):
    """`camera` on a slide whose reading is `pupil` [m] where its entrance pupil stands over the turntable's axis;
    `slides` [m] and `turns` [rad]: readings at which the pins `near` (lower half of the picture) and `far` (upper) are
    photographed. Every slide is off by chance by `u_slide` [m], every picture's turn by `u_turn` [rad].
    """

    camera: Camera
    pupil: float
    slides: tuple[float, ...]
    turns: tuple[float, ...]
    near: Pin
    far: Pin
    u_slide: float = SLIDE
    u_turn: float = TURN
    sensor: Sensor = field(default_factory=lambda: Sensor(psf_sigma=0.9))
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "pupil"

    def __post_init__(self) -> None:
        if not (self.slides and self.turns) or min(self.u_slide, self.u_turn) < 0:
            raise InputError("A two-pin fixture needs readings of slide and turntable, off by no less than 0.")

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Readings with what they are off by."""
        slide = np.array(self.slides) + self.u_slide * rng.standard_normal(len(self.slides))
        shape = len(self.slides), len(self.turns)
        turn = np.array(self.turns) + self.u_turn * rng.standard_normal(shape)
        return Layout(
            said={
                "kind": "two-pin",
                "images": "pupil {slide:03d} {turn}.png",
                "slides": [metres(one) for one in self.slides],
                "turntable": [radians(one) for one in self.turns],
                "near_pin": "lower",
                "far_pin": "upper",
                "u_slide": metres(self.u_slide) if self.u_slide else None,
                "u_turntable": radians(self.u_turn) if self.u_turn else None,
            },
            truth={"pupil.slide": self.pupil, "slide": slide, "turn": turn},
            pictures={
                f"pupil {s:03d} {t}.png": partial(self._photograph, self.pupil - float(slide[s]), float(turn[s, t]))
                for s, t in np.ndindex(shape)
            },
        )

    def _photograph(self, forward: float, turn: float, rng: np.random.Generator) -> np.ndarray:
        pose = turntable_pose(forward, turn)
        return photograph_pins(self.camera, pose, pins=(self.near, self.far), sensor=self.sensor, rng=rng)

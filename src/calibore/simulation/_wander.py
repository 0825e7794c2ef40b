"""How a carriage strays from its path: another pose error at every stop, the same for the same seed."""

from dataclasses import dataclass

import numpy as np

from calibore.errors import InputError
from calibore.geometry import Pose


@dataclass(frozen=True)
class Wander:
    """Standard deviations of roll, pitch, yaw [rad], shift across the pipe in each direction and along it [m]."""

    roll: float = 0.0
    tilt: float = 0.0
    shift: float = 0.0
    axial: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("roll", "tilt", "shift", "axial"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} of a wandering carriage must not be negative, got {getattr(self, name):g}.")

    def at(self, station: int) -> Pose:
        """The error at a station, in the frame of the rig that stands right."""
        errors = np.random.default_rng([self.seed, station, 7]).standard_normal(6)
        roll, pitch, yaw = errors[:3] * [self.roll, self.tilt, self.tilt]
        return Pose.from_roll_pitch_yaw(
            float(roll), float(pitch), float(yaw), translation=errors[3:] * [self.shift, self.shift, self.axial]
        )

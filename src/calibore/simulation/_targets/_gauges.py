"""Pictures of a laser's line in ring gauges, for planes and cones of light."""

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import Rig, SideFacing
from calibore.rigs._writing import rig_toml
from calibore.simulation._light import LineLight, lit_line
from calibore.simulation._picture import photograph_all
from calibore.simulation._sensor import Sensor
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres, radians
from calibore.simulation._targets._values import rig_values
from calibore.simulation._wall import PipeWall


@dataclass(frozen=True)
class Gauge:
    """A ring gauge of `diameter` [m], stated; the rig stands at `centre` [m] in it."""

    diameter: float
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not 2 * np.hypot(*self.centre) < self.diameter:
            raise InputError(
                f"The rig stands inside its gauge: diameter {1e3 * self.diameter:g} mm, centre "
                f"{1e3 * float(np.hypot(*self.centre)):g} mm beside the rig."
            )


@dataclass(frozen=True, eq=False)
class GaugeTarget(Target):
    """`gauges` put over `rig` (as it truly is), one after the other: diameters off by chance with standard deviation
    `u` [m], inclined by chance with `u_tilt` [rad] about either axis. Photographed `takes` times; of several lasers
    each shines in the takes it names.

    target.toml states `u`, `u_tilt` and the rig's `design`, as it is where None, in design.toml.
    """

    rig: Rig
    gauges: tuple[Gauge, ...]
    design: Rig | None = None
    u: float = 5e-6
    u_tilt: float = 0.005
    takes: int = 1
    line: LineLight = field(default_factory=LineLight)
    sensor: Sensor = field(default_factory=Sensor)
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "rig"

    def __post_init__(self) -> None:
        if isinstance(self.rig.mount, SideFacing):
            raise InputError("A side-facing head is calibrated on a flat at ranges, not in ring gauges.")
        if not self.gauges or self.takes < 1 or not (self.u > 0 and self.u_tilt > 0):
            raise InputError("A gauge target needs a gauge, a take, and a positive u and u_tilt.")

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Gauges with the errors of their making and placing."""
        count = len(self.gauges)
        stated = np.array([gauge.diameter for gauge in self.gauges])
        diameter = stated + self.u * rng.standard_normal(count)
        tilt = self.u_tilt * rng.standard_normal((count, 2))
        looks = [
            {"images": f"gauge {number:02d} {{take}}.png", "gauge": metres(gauge.diameter), "u": metres(self.u)}
            for number, gauge in enumerate(self.gauges)
        ]
        return Layout(
            said={"kind": "ring-gauge", "rig": "design.toml", "u_tilt": radians(self.u_tilt), "look": looks},
            truth={**rig_values(self.rig), "gauge_stated": stated, "gauge_diameter": diameter, "gauge_tilt": tilt},
            pictures={
                f"gauge {number:02d} {take}.png": partial(
                    self._photograph, PipeWall(float(diameter[number]) / 2), self._pose(number, tilt[number]), take
                )
                for number in range(count)
                for take in range(self.takes)
            },
            files={"design.toml": rig_toml(self.design or self.rig)},
        )

    def _pose(self, number: int, tilt: np.ndarray) -> Pose:
        return Pose.from_roll_pitch_yaw(0.0, *tilt.tolist(), translation=(*self.gauges[number].centre, 0.0))

    def _photograph(self, wall: PipeWall, pose: Pose, take: int, rng: np.random.Generator) -> np.ndarray:
        lines = {
            number: lit_line(
                self.rig, wall, pipe_from_rig=pose, line=self.line, psf_sigma=self.sensor.psf_sigma, laser=number
            )
            for number, laser in enumerate(self.rig.lasers)
            if laser.is_lit(take)
        }
        return photograph_all(lines, self.rig, line=self.line, sensor=self.sensor, rng=rng)

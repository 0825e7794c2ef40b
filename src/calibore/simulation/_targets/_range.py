"""Pictures of the line that a side-facing head draws on a flat at known ranges."""

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from calibore.errors import InputError
from calibore.rigs import Rig, SideFacing
from calibore.simulation._known_surfaces import photograph_flat
from calibore.simulation._light import LineLight
from calibore.simulation._sensor import Sensor
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres, radians
from calibore.simulation._targets._values import rig_values

FOCUSED = 0.005 * 0.0254
"""m; standard deviation of a line 0.02 in wide where it has fallen to 1/e^2, as a head near the wall draws it."""


@dataclass(frozen=True, eq=False)
class RangeTarget(Target):
    """A flat before the side-facing head `rig` (as it truly is) at `origin` + index x `step` [m] for each of `indices`,
    every stop off by chance with standard deviation `u_range` [m]; inclined by `slope` along travel. Photographed
    `takes` times, in `room_takes` with room light, of brightness `room` of full scale.

    target.toml states the head's `design`, as it is where None; not u_range, which `stated` may add.
    """

    rig: Rig
    indices: tuple[int, ...]
    step: float
    design: Rig | None = None
    origin: float = 0.0
    u_range: float = 0.0
    slope: float = 0.0
    takes: int = 2
    room_takes: tuple[int, ...] = (0,)
    room: float = 0.4
    line: LineLight = field(default_factory=lambda: LineLight(sigma=FOCUSED))
    sensor: Sensor = field(default_factory=Sensor)
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "rig"

    def __post_init__(self) -> None:
        for rig in (self.rig, self.design):
            if rig is not None and not isinstance(rig.mount, SideFacing):
                raise InputError(f"A flat at ranges calibrates a side-facing head; this is a {rig.configuration} rig.")
        if not self.indices or len(set(self.indices)) < len(self.indices) or self.takes < 1 or self.u_range < 0:
            raise InputError("A range target needs different indices, a take, and a u_range that is not negative.")
        if not min(self.origin + index * self.step for index in self.indices) > 0:
            raise InputError(
                f"A flat stands at a positive range, got {1e3 * self.origin:g} mm and steps of {1e3 * self.step:g} mm."
            )

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Stops with what the slide is off by."""
        nominal = self.origin + self.step * np.array(self.indices, dtype=float)
        true = nominal + self.u_range * rng.standard_normal(nominal.size)
        return Layout(
            said={
                "kind": "range",
                "images": "range {index:03d} {take}.png",
                "range_step": metres(self.step),
                "range_origin": metres(self.origin) if self.origin else None,
                "room_light_takes": list(self.room_takes),
                **self._designed(),
            },
            truth={
                **rig_values(self.rig),
                "range_index": np.array(self.indices),
                "range_nominal": nominal,
                "range_true": true,
                "slope": self.slope,
            },
            pictures={
                f"range {index:03d} {take}.png": partial(self._photograph, place, take)
                for index, place in zip(self.indices, true.tolist(), strict=True)
                for take in range(self.takes)
            },
        )

    def _designed(self) -> dict[str, object]:
        rig = self.design or self.rig
        assert isinstance(rig.mount, SideFacing)
        return {
            "design_baseline": metres(rig.mount.baseline),
            "design_aim": radians(rig.mount.aim),
            "design_k": rig.camera.lens.k,
            "lens": rig.camera.lens.law,
            "principal_point": list(rig.camera.principal_point),
        }

    def _photograph(self, place: float, take: int, rng: np.random.Generator) -> np.ndarray:
        room = self.room if take in self.room_takes else 0.0
        return photograph_flat(
            self.rig, place, slope=self.slope, line=self.line, sensor=self.sensor, room=room, rng=rng
        )

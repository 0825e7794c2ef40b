"""A whole scan by touch: which probe turns where in which pipe, and what its pin and potentiometer do wrong."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import Probe
from calibore.simulation._tactile._contact import Shank
from calibore.simulation._targets._probe import CALIPER, CONTACT
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]
TURN = 2 * np.pi


@dataclass(frozen=True)
class Sticking:
    """Beside an edge, where the contact jumps by more than the ball's diameter from stop to stop, the pin sticks with
    `probability`; its reading is then `reach` [m] (from, to) too far out, evenly, negative where it lags behind.
    """

    probability: float = 0.3
    reach: tuple[float, float] = (0.002, 0.016)

    def __post_init__(self) -> None:
        if not 0 <= self.probability <= 1 or not self.reach[0] <= self.reach[1]:
            raise InputError(
                f"A pin sticks with a probability between 0 and 1 and a reach from less to more, got "
                f"{self.probability:g} and {1e3 * self.reach[0]:g} to {1e3 * self.reach[1]:g} mm."
            )


@dataclass(frozen=True)
class Diameters:
    """What calibrates the probe: `lengths` under a caliper, and diameters of the pipe at opposite `stops` of the ring
    number `ring`, one of them `wrong` [m] by so much each where it is given.
    """

    ring: int = 0
    stops: tuple[tuple[int, int], ...] = ()
    lengths: int = 34
    u_caliper: float = float(CALIPER)
    u_contact: float = CONTACT
    wrong: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class TactileSurvey:
    """`probe` (as it truly is, with the noise of a reading and its stroke) turns in `wall`: `stops` clocks a turn from
    `clock` [rad] on, `stations` rings at `origin` + n x `step` [m]. `pose` is pipe_from_probe, to which the axial
    position is added; the ball has `tip_radius` [m].

    The probe's file states `stated`; where that is None, tables of `diameters` lie in the folder instead, from which
    `calibore profile` makes the calibration. `bend` [m]: amplitude of the second Legendre polynomial over the stroke by
    which the probe is not straight; `drift` [m]: standard deviation of what it shifts by during the scan, stated as
    `stated_drift`; `bias` [V]: mean and standard deviation of the bias voltage.
    """

    name: str
    wall: PipeWall
    probe: Probe
    tip_radius: float
    stations: int
    origin: float
    step: float
    stops: int = 400
    clock: float = 0.0
    pose: Pose = field(default_factory=Pose.identity)
    stated: Probe | None = None
    diameters: Diameters = field(default_factory=Diameters)
    bend: float = 0.0
    drift: float = 0.0
    stated_drift: float | None = None
    bias: tuple[float, float] = (5.0, 0.002)
    sticking: Sticking = field(default_factory=lambda: Sticking(0.0))
    shank: Shank | None = None

    def __post_init__(self) -> None:
        if self.stations < 1 or self.stops < 4 or self.step == 0:
            raise InputError(
                f"A scan by touch needs a ring, 4 stops and a step, got {self.stations} rings, {self.stops} stops, "
                f"{1e3 * self.step:g} mm."
            )
        if not 0 < self.tip_radius < self.wall.clearance / 2:
            raise InputError(
                f"The ball's radius must be positive and small in the pipe, got {1e3 * self.tip_radius:g} mm."
            )
        if min(self.drift, self.bias[0], self.bias[1]) < 0 or not self.bias[0] > 5 * self.bias[1]:
            raise InputError("Drift must not be negative, and the bias voltage far above 0 for its scatter.")
        if self.shank and self.shank.setback < self.tip_radius:
            raise InputError("The shank's front lies behind the middle of the ball: its setback exceeds tip_radius.")
        self._check_diameters()

    def _check_diameters(self) -> None:
        known = self.diameters
        if not 0 <= known.ring < self.stations or not all(0 <= n < self.stops for pair in known.stops for n in pair):
            raise InputError(
                f"Diameters are measured at rings 0 to {self.stations - 1} and stops 0 to {self.stops - 1}, got ring "
                f"{known.ring}, stops {known.stops}."
            )

    @property
    def clocks(self) -> Array:
        """Where the pin points (stops,) [rad]."""
        return self.clock + np.arange(self.stops, dtype=np.float64) * (TURN / self.stops)

    @property
    def axials(self) -> Array:
        """Where the rings lie (stations,) [m]."""
        return self.origin + np.arange(self.stations, dtype=np.float64) * self.step

    @property
    def opposite(self) -> tuple[tuple[int, int], ...]:
        """The stops of the diameters; where none are given, three a third of a turn apart."""
        half = self.stops // 2
        return self.diameters.stops or tuple((n * half // 3, n * half // 3 + half) for n in range(3))

    def pose_at(self, station: int) -> Pose:
        """pipe_from_probe at this ring."""
        axial = np.array([0.0, 0.0, self.origin + station * self.step])
        return Pose(self.pose.rotation, self.pose.translation + axial)

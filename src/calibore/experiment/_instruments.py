"""The lasers of the experiment: what each is at the scan, what it was when it was calibrated, how it is driven."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from calibore.experiment._pipe import experimental_pipe
from calibore.experiment._plan import Plan
from calibore.experiment._published import (
    EXTRINSIC,
    HEAD_CHANGE,
    INCH,
    PLANES,
    TABLE_6_1,
    TABLE_8_2,
)
from calibore.geometry import Pose
from calibore.lasers import Cone, Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing
from calibore.simulation import LineLight, Station, Survey

WIDTH, HEIGHT, CENTRE = 1024, 768, (512.0, 384.0)
CONE_BEHIND = 12 * INCH
"""How far behind the wall it measures a cone's rig stands."""
HEAD_LINE = 0.00017
"""m, standard deviation: the head's laser is focused at short range, a millimetre wide line would be 12 px thick."""


@dataclass(frozen=True, eq=False)
class Instrument:
    """`rig` as it is at the scan, `before` as it was at the calibration where it has changed since; `drift`: standard
    uncertainties that a rig file states of such a change, by key, as text. `pose` in the pipe (Table 8.2); `kind`
    "plane", "cone" or "side"; `baseline` as it is called [in]. `origin` [m] of its station 0; its `line` of light.
    """

    name: str
    title: str
    kind: str
    baseline: float
    rig: Rig
    before: Rig | None
    drift: Mapping[str, str]
    pose: Pose
    origin: float
    line: LineLight = field(default_factory=LineLight)

    def survey(self, plan: Plan) -> Survey:
        """All stations of `plan`."""
        side = self.kind == "side"
        if side:
            stations = tuple(
                Station(stop, plan.side_takes, angular=n) for stop in range(plan.stops) for n in range(plan.angles)
            )
        else:
            stations = tuple(Station(number, plan.takes) for number in range(plan.rings))
        return Survey(
            name=f"test pipe, {self.title}",
            rig=self.rig,
            wall=experimental_pipe(),
            stations=stations,
            origin=self.origin,
            step=plan.stop_step if side else plan.ring_step,
            pose=self.pose,
            line=self.line,
            prefix=self.name,
            angular=(0.0, 2 * np.pi / plan.angles) if side else None,
        )

    def seed(self, plan: Plan) -> int:
        """Of its pictures: every instrument has noise of its own."""
        return 100 * plan.seed + [one.name for one in instruments()].index(self.name)

    def sections(self, plan: Plan) -> list[Survey]:
        """The survey cut into pieces."""
        survey, side = self.survey(plan), self.kind == "side"
        pieces = plan.sections(plan.stops if side else plan.rings, size=1 if side else plan.section)
        return [
            replace(survey, stations=tuple(one for one in survey.stations if one.number in piece)) for piece in pieces
        ]


@cache
def instruments() -> tuple[Instrument, ...]:
    """Four plane rigs, a cone, a side-facing head."""
    return (*(_plane(baseline) for baseline in PLANES), _cone(), _head())


def instrument_named(name: str) -> Instrument:
    return next(one for one in instruments() if one.name == name)


def _camera(lens: str, k: float) -> Camera:
    return Camera(WIDTH, HEIGHT, Lens(lens, k, HEIGHT / 2), CENTRE)


def _pose(name: str) -> Pose:
    """Upwards is positive in the table, downwards here."""
    said = TABLE_8_2[name]
    shift = (said.shift_x * INCH, -said.shift_y * INCH, 0.0)
    return Pose.from_roll_pitch_yaw(np.radians(said.roll), translation=shift)


def _plane(baseline: int) -> Instrument:
    """Rigs of Table 6.1; since their calibration the baseline has changed by the scale of Table 8.2."""
    fitted, name = TABLE_6_1["sine-law"][baseline], f"plane-{baseline}in"
    scales = [one.scale for one in TABLE_8_2.values() if one.scale is not None]
    usual = float(np.sqrt(np.mean((np.array(scales) - 1) ** 2)))
    length = fitted.baseline * INCH
    camera = _camera("sine-law", fitted.k)

    def rig(distance: float) -> Rig:
        return Rig("perpendicular-plane", camera, (Laser(Plane(distance), "red"),))

    before = rig(length / (TABLE_8_2[name].scale or 1.0))
    drift = {"baseline": f"{1e3 * usual * length:.4g} mm"}
    return Instrument(
        name, f"plane, {baseline} in", "plane", baseline, rig(length), before, drift, _pose(name), -length
    )


def _cone() -> Instrument:
    """Aimed so that its ring on the nominal wall lies 12 in ahead; not in the dissertation's experiment."""
    cone = Cone(3 * INCH, np.radians(11.416827088958769), np.radians(25.453070556885248))
    rig = Rig("single-cone", _camera("sine-law", 571.0), (Laser(cone, "red"),))
    return Instrument("cone-3in", "cone, 3 in", "cone", 3, rig, None, {}, _pose("plane-12in"), -CONE_BEHIND)


def _head() -> Instrument:
    """The head of Table 7.1; since its calibration it has changed as Table 8.1 found."""
    factors = (1 + np.array(HEAD_CHANGE) / 100).tolist()
    now = head_of(*(value * factor for value, factor in zip(EXTRINSIC, factors, strict=True)))
    drift = {
        "baseline": f"{EXTRINSIC.baseline * HEAD_CHANGE.baseline / 100:.4g} in",
        "aim": f"{abs(EXTRINSIC.aim * HEAD_CHANGE.aim / 100):.4g} deg",
        "k": f"{now.camera.lens.k * HEAD_CHANGE.per_pixel / 100:.4g}",
    }
    name, line = "side-2.4in", LineLight(sigma=HEAD_LINE)
    return Instrument(name, "side-facing, 2.4 in", "side", 2.4, now, head_of(*EXTRINSIC), drift, _pose(name), 0.0, line)


def head_of(baseline: float, aim: float, per_pixel: float) -> Rig:
    """A side-facing head; baseline [in], aim [deg], scale of its equidistant lens [deg per px]."""
    camera = _camera("equidistant", 1 / np.radians(per_pixel))
    mount = SideFacing(baseline * INCH, np.radians(aim))
    return Rig("side-facing", camera, (Laser(Sheet(), "red"),), mount=mount)

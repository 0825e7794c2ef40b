"""Tables of a specification that describe a probe and a scan by touch."""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from calibore.documents import Angle, Document, Length, read_document
from calibore.geometry import Pose
from calibore.rigs import Probe, read_probe
from calibore.simulation._spec import AxialTable, PipeTable, PoseTable
from calibore.simulation._spec_parts import MOST, Count, Number
from calibore.simulation._tactile import Diameters, Shank, Sticking, TactileSurvey
from calibore.uncertainty import Covariance

Positive = Annotated[Length, Field(gt=0)]
NotNegative = Annotated[Length, Field(ge=0)]


class ProbeTable(Document):
    """A probe as it truly is."""

    slope: Length
    intercept: Length
    noise: NotNegative = 0.0
    stroke: tuple[Number, Number] = (0.0, 1.0)

    def probe(self) -> Probe:
        """The probe, exactly known."""
        nothing = Covariance(("probe.slope", "probe.intercept"), np.zeros((2, 2)))
        return Probe(self.slope, self.intercept, nothing, self.noise, stroke=self.stroke)


class _Sticking(Document):
    probability: Annotated[Number, Field(ge=0, le=1)] = Sticking.probability
    reach: tuple[Length, Length] = Sticking.reach


class _Shank(Document):
    radius: Positive
    setback: Positive


class _Diameters(Document):
    ring: Count = Diameters.ring
    stops: tuple[tuple[Count, Count], ...] = ()
    lengths: Annotated[int, Strict(), Field(ge=2, le=MOST)] = Diameters.lengths
    u_caliper: NotNegative = Diameters.u_caliper
    u_contact: NotNegative = Diameters.u_contact
    wrong: tuple[Length, ...] = ()


class _Tactile(Document):
    probe: ProbeTable
    tip_radius: Positive
    stated: str | None = None
    diameters: _Diameters = _Diameters()
    bend: Length = 0.0
    drift: NotNegative = 0.0
    stated_drift: NotNegative | None = None
    bias: tuple[Number, Number] = TactileSurvey.bias
    sticking: _Sticking | None = None
    shank: _Shank | None = None


class _Angular(Document):
    origin: Angle = 0.0
    stops: Annotated[int, Strict(), Field(ge=4, le=MOST)] = TactileSurvey.stops


class _Motion(Document):
    axial: AxialTable
    angular: _Angular = _Angular()
    pose: PoseTable = PoseTable()


class _Spec(Document):
    format: Literal["calibore-simulation/1"]
    name: Annotated[str, Field(min_length=1)]
    seed: Count = 0
    pipe: PipeTable
    tactile: _Tactile
    motion: _Motion


def read_touch(path: Path) -> tuple[TactileSurvey, int]:
    """The scan by touch that `path` specifies, and its seed."""
    spec = read_document(path, _Spec)
    said, motion, pose = spec.tactile, spec.motion, spec.motion.pose
    rotation = {"roll": pose.roll, "pitch": pose.pitch, "yaw": pose.yaw}
    survey = TactileSurvey(
        name=spec.name,
        wall=spec.pipe.wall(path.parent),
        probe=said.probe.probe(),
        tip_radius=said.tip_radius,
        stations=motion.axial.stations,
        origin=motion.axial.origin,
        step=motion.axial.step,
        stops=motion.angular.stops,
        clock=motion.angular.origin,
        pose=Pose.from_roll_pitch_yaw(**rotation, translation=(pose.x, pose.y, 0.0)),
        stated=None if said.stated is None else read_probe(path.parent / said.stated),
        diameters=Diameters(**said.diameters.model_dump()),
        bend=said.bend,
        drift=said.drift,
        stated_drift=said.stated_drift,
        bias=said.bias,
        sticking=Sticking(0.0) if said.sticking is None else Sticking(**said.sticking.model_dump()),
        shank=None if said.shank is None else Shank(**said.shank.model_dump()),
    )
    return survey, spec.seed

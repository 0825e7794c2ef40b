"""A candidate: one configuration with one camera, one lens and its lengths; how it is built, how large it is."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import Assumptions
from calibore.design._requirement import BodyTable, CameraChoice, Requirement
from calibore.design._studies import asymmetric_rig, coaxial_rig, cone_rig, plane_rig, reversed_rig
from calibore.lasers import Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing
from calibore.uncertainty import Distribution

CONES = ("single-cone", "dual-cone", "asymmetric-cone")
"""Configurations whose laser stands beside the camera."""
ON_AXIS = ("coaxial-cone", "reversed-cone")
HEADS = ("side-facing", "rotating-spot")
SECOND_CLOCK = -np.pi / 2
"""Of the other laser of a dual cone (Swanbom 2007, section 3.3.5): each is blind where the other sees best."""
EDGE = 2.0
"""Pixels that stay free at the image's edge: a line has a width."""


@dataclass(frozen=True)
class Candidate:
    """`baseline` [m] (the offset of a cone on the axis), `projection` [m] (0 where there is none) and lens scale `k`
    [px] of a `configuration`.
    """

    configuration: str
    camera: CameraChoice
    lens: str
    baseline: float
    projection: float
    k: float

    def rig(self, wanted: Requirement) -> Rig:
        """The rig with its camera and what is known of it; raises InputError where the geometry is impossible.

        It states no noise of the line: what was assumed for the design, the pictures will tell.
        """
        if self.configuration in HEADS:
            return _head(self, wanted)
        rig = reference_rig(self.configuration, self.baseline, self.projection, wanted)
        return replace(rig, camera=camera_of(self))

    def length(self, laser: BodyTable) -> float:
        """Along the pipe [m], from the back of the camera to the foremost laser part; of a head its thickness."""
        if self.configuration in HEADS:
            return max(self.camera.body_diameter, laser.diameter)
        if self.configuration in CONES:
            return max(self.camera.body_length, laser.length)
        behind = 0.0 if self.configuration == "coaxial-cone" else laser.length
        return self.camera.body_length + self.baseline + behind

    def diameter(self, laser: BodyTable, aim: float = 0.0) -> float:
        """Of the circle about the rig axis [m] that holds camera and lasers; `aim` [rad] of a head's camera."""
        body = self.camera
        if self.configuration in CONES:
            return max(body.body_diameter, 2 * self.baseline + laser.diameter)
        if self.configuration not in HEADS:
            return max(body.body_diameter, laser.diameter)
        back = np.array([np.sin(aim), -np.cos(aim)]) * body.body_length
        across = np.array([np.cos(aim), np.sin(aim)]) * body.body_diameter / 2
        pupil = np.array([self.baseline, 0.0])
        corners = [pupil + step + side for step in (0 * back, back) for side in (across, -across)]
        return max(laser.diameter, 2 * float(max(np.hypot(*corner) for corner in corners)))

    def fits(self, wanted: Requirement, aim: float = 0.0) -> bool:
        """Whether camera and laser stand clear of each other and pass the crawler's envelope and the smallest pipe."""
        body, laser = self.camera, wanted.laser
        beside = self.configuration in (*CONES, *HEADS)
        if beside and 2 * self.baseline < body.body_diameter + laser.diameter:
            return False
        return self.diameter(laser, aim) <= widest(wanted)


def widest(wanted: Requirement) -> float:
    """Largest diameter of a rig [m]."""
    return min(wanted.crawler.diameter, 2 * wanted.smallest_wanted)


def reference_rig(configuration: str, baseline: float, projection: float, wanted: Requirement) -> Rig:
    """A forward-looking rig of these lengths [m] with its uncertainties; its camera is to be replaced."""
    nominal = wanted.nominal_radius
    build = {
        "perpendicular-plane": lambda D, _, **kw: plane_rig(D, **kw),
        "single-cone": cone_rig,
        "dual-cone": lambda D, L, **kw: cone_rig(D, L, second_clock=SECOND_CLOCK, **kw),
        "coaxial-cone": coaxial_rig,
        "asymmetric-cone": asymmetric_rig,
        "reversed-cone": reversed_rig,
    }[configuration]
    return build(baseline / nominal, projection / nominal, nominal_radius=nominal, inputs=inputs_of(wanted))


def inputs_of(wanted: Requirement) -> Assumptions:
    """Lengths within limits, angles that move with them, noise along the scan: `HONEST` with the file's numbers."""
    limit = wanted.noise.length.at(wanted.nominal_radius) / wanted.nominal_radius
    return Assumptions(
        Distribution.RECTANGULAR.u_of_limits(limit), Distribution.RECTANGULAR, u_pixel=wanted.noise.stripe
    )


def camera_of(candidate: Candidate) -> Camera:
    choice = candidate.camera
    height = 1 if candidate.configuration == "rotating-spot" else choice.height
    lens = Lens(candidate.lens, candidate.k, height / 2)
    return Camera(choice.width, height, lens, (choice.width / 2, height / 2))


def head_view(baseline: Any, reach: float, half_angle: Any) -> Any:
    """Aim [rad] of a camera `baseline` [m] beside the sheet whose view of +-`half_angle` [rad] ends at `reach` [m]."""
    return np.pi / 2 - np.arctan2(reach, baseline) + half_angle


def aim_by_lengths(baseline: Any, aim: Any) -> NDArray[np.float64]:
    """(2, ...) derivatives of the aim by the baseline and by the range at which the camera's axis meets the sheet:
    tan(aim) = baseline / range.
    """
    return np.stack([np.sin(aim) * np.cos(aim), -(np.sin(aim) ** 2)]) / baseline


def _head(candidate: Candidate, wanted: Requirement) -> Rig:
    camera = camera_of(candidate)
    half_angle = float(camera.lens.zenith(candidate.camera.width / 2 - EDGE))
    aim = float(head_view(candidate.baseline, wanted.radii[1], half_angle))
    jacobian = np.vstack([[1.0, 0.0], aim_by_lengths(candidate.baseline, aim)])
    names = ("laser.baseline", "laser.aim")
    known = inputs_of(wanted).covariance(names, jacobian, nominal_radius=wanted.nominal_radius)
    mount = SideFacing(candidate.baseline, aim)
    return Rig(candidate.configuration, camera, (Laser(Sheet()),), known, mount=mount)

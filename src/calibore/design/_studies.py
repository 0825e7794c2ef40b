"""Reference rigs from dimensionless parameters, as the dissertation studies them: lengths in nominal radii.

Every rig gets the camera its measuring limits ask for and the covariance that its `inputs` state.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._cameras import Axis, Imager, checked
from calibore.lasers import Cone, Plane, Sheet, ring_angles
from calibore.optics import Camera
from calibore.rigs import Laser, Rig, SideFacing
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]


def plane_rig(
    baseline_parameter: float,
    *,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A perpendicular plane; the camera sees `maximum_radius` across its short axis (Swanbom 2007, eq. 4-16)."""
    baseline = checked(baseline_parameter, "baseline", hint="the laser plane stands ahead of the camera")
    checked(maximum_radius, "maximum radius", hint="state the largest radius to be seen")
    camera = Imager(width, height, lens).seeing(np.arctan2(maximum_radius, baseline), across="short")
    known = inputs.covariance(("laser.baseline",), np.eye(1), nominal_radius=nominal_radius)
    return Rig("perpendicular-plane", camera, (Laser(Plane(baseline * nominal_radius)),), known)


def cone_rig(
    baseline_parameter: float,
    projection_parameter: float,
    *,
    second_clock: float | None = None,
    nominal_radius: float = 1.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    across: Axis = "long",
    inputs: Assumptions = HONEST,
) -> Rig:
    """One cone at the crown, or a second at `second_clock` [rad] too (the dissertation's: -90 deg).

    The camera sees theta_max = aim + half angle (Swanbom 2007, eqs. 3-38, 3-58) across its long axis.
    """
    hint = "the laser stands inside the pipe, beside the camera"
    baseline = checked(baseline_parameter, "baseline", below=1.0, hint=hint) * nominal_radius
    projection = checked(projection_parameter, "projection", hint="the ring falls ahead") * nominal_radius
    aim, half_angle, slopes = ring_angles(baseline, projection, nominal_radius)
    camera = Imager(width, height, lens).seeing(float(aim + half_angle), across=across)
    clocks = (0.0,) if second_clock is None else (0.0, float(second_clock))
    takes = (None,) if second_clock is None else ((0,), (1,))  # two lines are told apart by lighting them in turn
    cones = (Cone(baseline, float(aim), float(half_angle), clock) for clock in clocks)
    lasers = tuple(Laser(cone, takes=lit) for cone, lit in zip(cones, takes, strict=True))
    jacobian = np.vstack([[1.0, 0.0], slopes])
    known = _of_each_laser(inputs, ("baseline", "aim", "half_angle"), jacobian, len(clocks), nominal_radius)
    return Rig("single-cone" if second_clock is None else "dual-cone", camera, lasers, known)


def coaxial_rig(
    offset_parameter: float,
    projection_parameter: float,
    *,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A cone about the camera axis, its apex `offset_parameter` ahead of the pupil, its ring `projection_parameter`
    ahead of the apex (Swanbom 2007, eqs. 2-1, 2-2); the short axis of the image sees `maximum_radius`.
    """
    offset = checked(offset_parameter, "offset", hint="the apex of a coaxial cone stands ahead of the camera")
    projection = checked(projection_parameter, "projection", hint="the ring falls ahead of the apex")
    zenith = np.arctan2(maximum_radius, offset + maximum_radius * projection)
    camera = Imager(width, height, lens).seeing(zenith, across="short")
    cone = Cone(0.0, 0.0, np.arctan(1 / projection), offset=offset * nominal_radius)
    return Rig("coaxial-cone", camera, (Laser(cone),), _on_axis(inputs, projection, nominal_radius, sign=-1))


def reversed_rig(
    offset_parameter: float,
    projection_parameter: float,
    *,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A cone ahead of the camera whose light falls back: its ring is `projection_parameter` behind its apex
    (Swanbom 2007, eq. 2-8); the short axis of the image sees `maximum_radius`.
    """
    projection = checked(projection_parameter, "projection", hint="state how far behind its apex the ring falls")
    hint = "the ring of a reversed cone falls ahead of the camera only with the apex farther ahead than the projection"
    offset = checked(offset_parameter, "offset", above=projection, hint=hint)
    zenith = np.arctan2(maximum_radius, offset - maximum_radius * projection)
    camera = Imager(width, height, lens).seeing(zenith, across="short")
    cone = Cone(0.0, 0.0, np.pi - np.arctan(1 / projection), offset=offset * nominal_radius)
    return Rig("reversed-cone", camera, (Laser(cone),), _on_axis(inputs, projection, nominal_radius, sign=1))


def asymmetric_rig(
    baseline_parameter: float,
    projection_parameter: float,
    *,
    nominal_radius: float = 1.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    across: Axis = "long",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A cone beside the camera with parallel axes, one nominal radius wide `projection_parameter` ahead
    (Swanbom 2007, eqs. 2-3 to 2-7); the camera sees the light at the crown down to the radius (1 + D) / 2.
    """
    hint = "the laser stands inside the pipe, beside the camera"
    baseline = checked(baseline_parameter, "baseline", below=1.0, hint=hint)
    projection = checked(projection_parameter, "projection", hint="the light falls ahead")
    least = (1 + baseline) / 2
    camera = Imager(width, height, lens).seeing(np.arctan2(least, (least - baseline) * projection), across=across)
    cone = Cone(baseline * nominal_radius, 0.0, np.arctan(1 / projection))
    jacobian = np.diag([1.0, -1 / (1 + projection**2) / nominal_radius])
    known = inputs.covariance(("laser.baseline", "laser.half_angle"), jacobian, nominal_radius=nominal_radius)
    return Rig("asymmetric-cone", camera, (Laser(cone),), known)


def side_rig(
    baseline_parameter: float,
    *,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A side-facing head that sees from (1 + D) / 2 to `maximum_radius` along u (Swanbom 2007, eqs. 5-21 to 5-23)."""
    hint = "the camera stands inside the pipe, beside the sheet"
    baseline = checked(baseline_parameter, "baseline", below=1.0, hint=hint)
    least, hint = (1 + baseline) / 2, "it lies beyond the inner limit, half way from the camera to the wall"
    checked(maximum_radius, "maximum radius", above=least, hint=hint)
    camera, aim = side_view(baseline, least, maximum_radius, Imager(width, height, lens))
    mount = SideFacing(baseline * nominal_radius, aim)
    jacobian = np.vstack([[1.0, 0.0], _aim_slopes(baseline, maximum_radius) / nominal_radius])
    known = inputs.covariance(("laser.baseline", "laser.aim"), jacobian, nominal_radius=nominal_radius)
    configuration = "rotating-spot" if height == 1 else "side-facing"
    return Rig(configuration, camera, (Laser(Sheet()),), known, mount=mount)


def spot_rig(
    baseline_parameter: float,
    *,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """A rotating spot with a line sensor (Swanbom 2007, section 2.3.1): the side-facing head with one row of pixels."""
    return side_rig(
        baseline_parameter,
        nominal_radius=nominal_radius,
        maximum_radius=maximum_radius,
        width=width,
        height=1,
        lens=lens,
        inputs=inputs,
    )


def side_view(baseline: float, least: float, most: float, imager: Imager) -> tuple[Camera, float]:
    """The camera that sees radii from `least` to `most` along u from `baseline` beside the sheet, and its aim [rad]
    (Swanbom 2007, eqs. 5-22, 5-23).
    """
    inner, outer = np.arctan2(least, baseline), np.arctan2(most, baseline)
    return imager.seeing(float(outer - inner) / 2, across="u"), float(np.pi / 2 - (inner + outer) / 2)


def _aim_slopes(baseline: float, most: float) -> Array:
    """(2,) derivatives of the aim by baseline and maximum radius (Swanbom 2007, eqs. 5-35, 5-34)."""
    D, Rmax, Rmin = baseline, most, (1 + baseline) / 2
    by_baseline = (Rmax / (D**2 + Rmax**2) + 0.5 / (D**2 + Rmin**2)) / 2
    return np.array([by_baseline, -D / (2 * (D**2 + Rmax**2))])


def _on_axis(inputs: Assumptions, projection: float, nominal_radius: float, *, sign: int) -> Covariance:
    jacobian = np.diag([1.0, sign / (1 + projection**2) / nominal_radius])
    return inputs.covariance(("laser.offset", "laser.half_angle"), jacobian, nominal_radius=nominal_radius)


def _of_each_laser(
    inputs: Assumptions, names: tuple[str, ...], jacobian: Array, lasers: int, nominal_radius: float
) -> Covariance:
    """The lasers are built apart: what is not known of one says nothing of the other."""
    tables = ["laser"] if lasers == 1 else [f"laser.{number}" for number in range(lasers)]
    known = [
        inputs.covariance(tuple(f"{table}.{name}" for name in names), jacobian, nominal_radius=nominal_radius)
        for table in tables
    ]
    return known[0] if lasers == 1 else known[0].joined(known[1])

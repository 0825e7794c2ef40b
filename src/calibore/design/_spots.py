"""A ring of beams: the spot array of the literature (Swanbom 2007, section 2.3)."""

import numpy as np

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._cameras import Imager, checked
from calibore.errors import InputError
from calibore.lasers import Beam
from calibore.rigs import Laser, Rig


def spot_array_rig(
    baseline_parameter: float,
    *,
    beams: int = 8,
    nominal_radius: float = 1.0,
    maximum_radius: float = 2.0,
    width: int = 1024,
    height: int = 768,
    lens: str = "equidistant",
    inputs: Assumptions = HONEST,
) -> Rig:
    """`beams` beams from one point `baseline_parameter` ahead of the pupil, straight outwards at even clocks; the
    camera sees `maximum_radius` across its short axis. Each beam's place and its direction are known to
    `inputs.length`, the direction over one nominal radius.
    """
    baseline = checked(baseline_parameter, "baseline", hint="the beams start ahead of the camera")
    if beams < 1:
        raise InputError(f"A spot array needs at least one beam, got {beams}; eight make a useful ring.")
    camera = Imager(width, height, lens).seeing(np.arctan2(maximum_radius, baseline), across="short")
    clocks = np.arange(beams) * (2 * np.pi / beams)
    lasers = tuple(Laser(Beam(0.0, 0.0, baseline * nominal_radius, np.pi / 2, float(clock))) for clock in clocks)
    tables = ["laser"] if beams == 1 else [f"laser.{number}" for number in range(beams)]
    names = tuple(f"{table}.{name}" for table in tables for name in ("x", "y", "z", "zenith", "clock"))
    steps = np.tile([1.0, 1.0, 1.0, 1 / nominal_radius, 1 / nominal_radius], beams)
    known = inputs.covariance(names, np.diag(steps), nominal_radius=nominal_radius)
    return Rig("spot-array", camera, lasers, known)

"""The demonstration: a short 12 in pipe with everything an inspector looks for."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig
from calibore.simulation._chance import draw_rig
from calibore.simulation._light import LineLight
from calibore.simulation._parts import Dent, Harmonic, LateralOpening, Ovality, Rail, Roughness
from calibore.simulation._survey import Progress, Station, Survey, simulate_scan
from calibore.simulation._wall import PipeWall
from calibore.uncertainty import Covariance

INCH = 0.0254
STEP = 3 * INCH
STATIONS = 10
TWO_TAKES = (0, 5)
STRUT_STATION = 7


def demo_scan(folder: Path | str, *, seed: int = 1, progress: Progress | None = None) -> Path:
    """Simulate the demonstration survey (`demo_survey`) into `folder`, see `simulate_scan`."""
    return simulate_scan(folder, demo_survey(seed=seed), seed=seed, progress=progress)


def demo_survey(*, seed: int = 1) -> Survey:
    """Ten stations 3 in apart in a 12 in pipe that grows oval to 2 %, with a dent, a lateral and a rail on the invert
    that ends before station 3 and hides the wall behind it; the rig a little off-centre, rolled and tilted; a strut's
    shadow at one station, two takes at two. The true rig differs from the stated one by a draw from the stated
    uncertainty, as in life.
    """
    stated = demo_rig()
    shadowed = replace(LineLight(), shadows=((np.radians(66.0), np.radians(14.0)),))
    stations = tuple(
        Station(number, 2 if number in TWO_TAKES else 1, shadowed if number == STRUT_STATION else None)
        for number in range(STATIONS)
    )
    return Survey(
        name="demonstration: 12 in pipe, 12 in baseline",
        rig=draw_rig(stated, np.random.default_rng([seed, 2])),
        wall=demo_wall(seed=seed),
        stations=stations,
        origin=-13.1 * INCH,
        step=STEP,
        pose=Pose.from_roll_pitch_yaw(0.026, 0.002, -0.003, translation=(0.17 * INCH, 0.09 * INCH, 0.0)),
        stated=stated,
    )


def demo_rig() -> Rig:
    """The 12 in baseline rig with its sine-law lens (Swanbom 2007, table 6.1), as its file states it."""
    camera = Camera(1024, 768, Lens("sine-law", 571.0, 384.0), (512.0, 384.0))
    uncertainty = {
        "laser.baseline": 0.006 * INCH,
        "camera.k": 0.3,
        "camera.principal_point_u": 0.3,
        "camera.principal_point_v": 0.3,
    }
    laser = Laser(Plane(13.1 * INCH), "red")
    return Rig("perpendicular-plane", camera, (laser,), covariance=Covariance.independent(uncertainty))


def demo_wall(*, seed: int = 1) -> PipeWall:
    """The demonstration pipe; axial 0 is the laser plane at station 0."""
    end = (STATIONS - 1) * STEP
    return PipeWall(
        6 * INCH,
        (
            Ovality((0.2, 2.0), axial=(0.0, end), axis=np.radians(80.0)),
            Harmonic(3, 0.004 * INCH, np.radians(75.0)),
            Dent(0.4 * INCH, np.radians(285.0), 4 * STEP, clock_width=np.radians(9.0), length=1.6 * INCH),
            LateralOpening(2.2 * INCH, 0.7 * INCH, np.radians(140.0), 8 * STEP, edge=0.9 * INCH),
            Roughness(0.0015 * INCH, 0.12 * INCH, seed),
            Rail(0.5 * INCH, 1.0 * INCH, axial=(-np.inf, 2.75 * STEP), edge=0.04 * INCH),
        ),
    )

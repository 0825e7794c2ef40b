"""Small surveys for the tests of the whole: four stations of a 12 in pipe in pictures of 320 x 240 px."""

import os
import shutil
from pathlib import Path

import pytest

from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig
from calibore.simulation import Ovality, PipeWall, Station, Survey, simulate_scan
from calibore.uncertainty import Covariance

INCH = 0.0254
RADIUS = 6 * INCH
BASELINE = 13.1 * INCH
STEP = 0.05
STATIONS = 4
OVAL_CLOCK = 0.7
"""Where the pipe is widest [rad]."""


def small_rig(width: int = 320, height: int = 240, *, channel: str | None = "red") -> Rig:
    """A sine-law camera that sees the 12 in pipe as a ring of some 80 px radius in 320 x 240 px."""
    camera = Camera(width, height, Lens("sine-law", 0.6 * width, height / 2), (width / 2, height / 2))
    stated = Covariance.independent({"laser.baseline": 0.006 * INCH, "camera.k": 0.1})
    return Rig("perpendicular-plane", camera, (Laser(Plane(BASELINE), channel),), covariance=stated)


def small_wall() -> PipeWall:
    """1 % oval throughout."""
    return PipeWall(RADIUS, (Ovality((1.0, 1.0), axial=(0.0, 1.0), axis=OVAL_CLOCK),))


def small_survey(rig: Rig | None = None, *, stations: int = STATIONS, takes: int = 1) -> Survey:
    """A rig a little off-centre and tilted."""
    return Survey(
        name="small pipe",
        rig=rig or small_rig(),
        wall=small_wall(),
        stations=tuple(Station(number, takes) for number in range(stations)),
        origin=0.0,
        step=STEP,
        pose=Pose.from_roll_pitch_yaw(0.0, 0.001, -0.002, translation=(0.002, -0.001, 0.0)),
    )


@pytest.fixture(scope="session")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scan folder `small`: read it, do not change it."""
    return simulate_scan(tmp_path_factory.mktemp("rendered") / "small", small_survey(), seed=1)


@pytest.fixture
def scan(rendered: Path, tmp_path: Path) -> Path:
    """A copy of the scan folder to spoil; its images are links until they are written anew."""
    folder = tmp_path / "small"
    shutil.copytree(rendered, folder, copy_function=_link)
    for name in ("scan.toml", "rig.toml"):
        (folder / name).unlink()
        shutil.copy(rendered / name, folder / name)
    return folder


def _link(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copy(source, target)

"""Photograph known things as a rig's camera would, so that `calibore calibrate` has something to do.

    python examples/photograph_a_target.py FOLDER [KIND]

Photographs and their target.toml go into FOLDER, and the true values are printed. KIND is one of
    rings        concentric rings at 90, 140 and 220 mm (if none is named)   calibore calibrate lens FOLDER ...
    chessboard   a board held in twelve ways; it is found by OpenCV,
                 which `pip install "calibore[targets]"` brings              calibore calibrate lens FOLDER ...
    gauges       a laser's line in four ring gauges, and the rig as it was
                 designed                                                    calibore calibrate rig FOLDER ...
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, moved, write_rig
from calibore.simulation import PipeWall, Sensor, photograph_board, photograph_rings, render_ring

CAMERA = Camera(1024, 768, Lens("equisolid-angle", 620.0, 384.0), (514.2, 380.9))
HEADING = 'format = "calibore-target/1"\n'
RINGS = """kind = "concentric-rings"
images = "target {take}.png"
ring_spacing = "25 mm"
rings = 12
spokes = 8
nominal_baseline = "90 mm"
"""
DISTANCES = (0.090, 0.140, 0.220)  # m
INK = 0.0015  # m
BOARD = """kind = "chessboard"
images = "board *.png"
square = "24 mm"
corners = [7, 5]
flatness = "0 mm"
"""
CORNERS, SQUARE = (7, 5), 0.024
COUNT = 12
GAUGES = 'kind = "ring-gauge"\nrig = "design.toml"\nu_tilt = "0.5 deg"\n'
DIAMETERS = (0.20, 0.23, 0.26, 0.29)  # m
TRUE = Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.1234, 0.008, -0.005), "red"),))
DESIGN = moved(TRUE, {"laser.baseline": -0.0034, "laser.tilt_x": -0.008, "laser.tilt_y": 0.005})


def rings(folder: Path, rng: np.random.Generator) -> str:
    """One photograph for each distance."""
    said = []
    for take, distance in enumerate(DISTANCES):
        pose = Pose.from_roll_pitch_yaw(
            *rng.normal(scale=0.02, size=3), translation=(*rng.normal(scale=0.002, size=2), -distance)
        )
        save(folder / f"target {take}.png", photograph_rings(
            CAMERA, pose, ring_spacing=0.025, rings=12, spokes=8, ink_width=INK, sensor=Sensor(), rng=rng
        ))  # fmt: skip
        along = pose.rotation[2, 2]
        said.append(f"{1e3 * distance / along:.4f} mm")
    write_target(folder, RINGS)
    return f"{camera_said()}; distances along the axis {', '.join(said)}"


def chessboard(folder: Path, rng: np.random.Generator) -> str:
    """The board all over the image, nearer and farther, facing the camera but for an inclination."""
    middle = SQUARE * np.array([(CORNERS[0] - 1) / 2, (CORNERS[1] - 1) / 2, 0.0])
    for number in range(COUNT):
        place, away = 2 * np.pi * number / COUNT, (0.0, 0.6, 0.8)[number % 3] * CAMERA.height / 2
        u, v = CAMERA.principal_point + away * np.array([np.cos(place), np.sin(place)])
        towards = CAMERA.unproject([u], [v]).direction[0]
        turn = facing(towards) @ Pose.from_roll_pitch_yaw(*rng.uniform(-0.6, 0.6, size=3)).rotation
        pose = Pose(turn, towards * (0.19, 0.25)[number % 2] - turn @ middle)
        sensor = Sensor(speckle_contrast=0.0)
        image = photograph_board(
            CAMERA, pose, kind="chessboard", corners=CORNERS, square=SQUARE, sensor=sensor, rng=rng
        )
        save(folder / f"board {number}.png", image)
    write_target(folder, BOARD)
    return camera_said()


def facing(towards: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) of a board whose back looks along the unit vector `towards`."""
    x = np.cross([0.0, 1.0, 0.0], towards)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(towards, x), towards], axis=1)


def gauges(folder: Path, rng: np.random.Generator) -> str:
    """A plane of light in four gauges, each set up a little aside and inclined."""
    looks = [GAUGES]
    for number, diameter in enumerate(DIAMETERS):
        pose = Pose.from_roll_pitch_yaw(
            0.0, *rng.normal(scale=0.006, size=2), translation=(*rng.uniform(-0.01, 0.01, size=2), 0.0)
        )
        save(folder / f"gauge {number}.png", render_ring(TRUE, PipeWall(diameter / 2), pipe_from_rig=pose, rng=rng))
        size = f"{1e3 * diameter:g} mm"
        looks.append(f'[[look]]\nimages = "gauge {number}.png"\ngauge = "{size}"\nu = "0.01 mm"\n')
    write_rig(DESIGN, folder / "design.toml")
    write_target(folder, "".join(looks))
    plane: Any = TRUE.lasers[0].surface
    return f"baseline {1e3 * plane.baseline:.4f} mm, tilt x {plane.tilt_x:g}, tilt y {plane.tilt_y:g}"


KINDS: dict[str, Callable[[Path, np.random.Generator], str]] = {
    "rings": rings,
    "chessboard": chessboard,
    "gauges": gauges,
}


def camera_said() -> str:
    u, v = CAMERA.principal_point
    return f"{CAMERA.lens.law}, k = {CAMERA.lens.k:g} px, principal point {u:g}, {v:g} px"


def write_target(folder: Path, text: str) -> None:
    (folder / "target.toml").write_text(HEADING + text, encoding="utf-8")


def save(path: Path, image: np.ndarray) -> None:
    from matplotlib.image import imsave

    imsave(path, image if image.ndim == 3 else np.repeat(image[:, :, None], 3, axis=2))


def main(arguments: list[str]) -> None:
    if len(arguments) not in (1, 2) or arguments[0].startswith("-") or arguments[-1] not in {arguments[0], *KINDS}:
        sys.exit(__doc__)
    folder, kind = Path(arguments[0]), arguments[1] if len(arguments) > 1 else "rings"
    folder.mkdir(parents=True, exist_ok=True)
    print("True values:", KINDS[kind](folder, np.random.default_rng(1)))


if __name__ == "__main__":
    main(sys.argv[1:])

"""Photograph a calibration target as a fisheye camera would, so that `calibore calibrate lens` has something to do.

    python examples/photograph_a_target.py FOLDER

Three photographs of concentric rings at 90, 140 and 220 mm and their target.toml go into FOLDER; the camera's true
values are printed.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.simulation import Sensor, photograph_rings

TARGET = """format = "calibore-target/1"
kind = "concentric-rings"
images = "target {take}.png"
ring_spacing = "25 mm"
rings = 12
spokes = 8
nominal_baseline = "90 mm"
"""
DISTANCES = (0.090, 0.140, 0.220)  # m
INK = 0.0015  # m


def photograph(folder: Path, *, seed: int = 1) -> Camera:
    """Write target.toml and one photograph for each distance; returns the camera they were taken with."""
    rng = np.random.default_rng(seed)
    camera = Camera(1024, 768, Lens("equisolid-angle", 620.0, 384.0), (514.2, 380.9))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "target.toml").write_text(TARGET, encoding="utf-8")
    for take, distance in enumerate(DISTANCES):
        roll, pitch, yaw = rng.normal(scale=0.02, size=3)
        aside = (*rng.normal(scale=0.002, size=2), -distance)
        pose = Pose.from_roll_pitch_yaw(roll, pitch, yaw, translation=aside)
        picture = photograph_rings(
            camera, pose, ring_spacing=0.025, rings=12, spokes=8, ink_width=INK, sensor=Sensor(), rng=rng
        )
        Image.fromarray(picture).save(folder / f"target {take}.png")
    return camera


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    true = photograph(Path(sys.argv[1]))
    print(f"{true.lens.law}, k = {true.lens.k:g} px, principal point {true.principal_point}")

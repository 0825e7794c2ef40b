"""Rendered photographs of ring targets with known truth, and the target.toml beside them: for the tests."""

from pathlib import Path

import numpy as np
from calibration_ring_marks import LAWS

from calibore.calibration._lens_models import CENTRE, LensModel
from calibore.calibration._rings._target import RingTarget
from calibore.geometry import Pose
from calibore.optics import LENS_LAWS
from calibore.simulation import Sensor, photograph_rings
from calibore.simulation._files import write_png

SPACING = 0.02
INK = 0.0014


def target_from_camera(target: RingTarget) -> Pose:
    """The pose that the renderer takes: the target's plane is its z = 0, its first spoke along its x."""
    normal = np.array([-target.tilt_x, -target.tilt_y, 1.0])
    along = np.array([1.0, 0.0, target.tilt_x])
    normal, along = normal / np.linalg.norm(normal), along / np.linalg.norm(along)
    across, cosine, sine = np.cross(normal, along), np.cos(target.roll), np.sin(target.roll)
    rotation = np.stack([cosine * along + sine * across, cosine * across - sine * along, normal])
    centre = target.point(np.zeros(1), np.zeros(1))[0]
    return Pose(rotation, -rotation @ centre)


def photograph(lens: LensModel, values, target: RingTarget, *, rings: int, size, rng, psf_sigma=1.0):
    """The picture (h, w, 3) of a target with 8 spokes."""
    return photograph_rings(
        lens.camera(values, width=size[0], height=size[1]),
        target_from_camera(target),
        ring_spacing=SPACING,
        rings=rings,
        spokes=8,
        ink_width=INK,
        sensor=Sensor(psf_sigma=psf_sigma),
        rng=rng,
    )


def random_photograph(rng: np.random.Generator, *, size=(640, 480)):
    """A random camera and target; the picture, its number of rings and the truth by dotted path."""
    law, rings = str(rng.choice(LAWS)), int(rng.integers(6, 10))
    widest = np.radians(rng.uniform(38, 60))
    values = {"camera.k": float(rng.uniform(0.85, 0.95) * size[1] / 2 / LENS_LAWS[law].ratio(widest))}
    values |= {name: float((n - 1) / 2 + rng.normal(0, 6)) for name, n in zip(CENTRE, size, strict=True)}
    tilt, aside = rng.normal(0, 0.02, 2), rng.normal(0, 0.01, 2) * rings * SPACING
    baseline = float(rings * SPACING / np.tan(widest))
    target = RingTarget(baseline, *tilt.tolist(), *aside.tolist(), float(rng.uniform(-np.pi, np.pi)))
    picture = photograph(
        LensModel(law), values, target, rings=rings, size=size, rng=rng, psf_sigma=float(rng.uniform(0.8, 1.3))
    )
    truth = {"camera.aspect": 1.0, **values, "laser.baseline": baseline}
    return picture, law, rings, truth | {"laser.tilt_x": target.tilt_x, "laser.tilt_y": target.tilt_y}


def write_target(folder: Path, pictures, *, rings: int, nominal_mm: float, **keys) -> Path:
    """target.toml in `folder` and the `pictures`, named by their take; further `keys` as TOML text."""
    for take, picture in enumerate(pictures):
        write_png(folder / f"rings {take}.png", picture)
    said = {
        "format": '"calibore-target/1"',
        "kind": '"concentric-rings"',
        "images": '"rings {take}.png"',
        "ring_spacing": f'"{1e3 * SPACING:g} mm"',
        "rings": str(rings),
        "spokes": "8",
        "nominal_baseline": f'"{nominal_mm:.1f} mm"',
    }
    lines = [f"{key} = {value}" for key, value in (said | keys).items() if value]
    (folder / "target.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder

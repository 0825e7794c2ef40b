"""Rendered photographs of ring targets with known truth, and the target.toml beside them: for the tests."""

from pathlib import Path

import numpy as np
from calibration_ring_marks import LAWS

from calibore.calibration._lens_models import CENTRE, LensModel
from calibore.calibration._rings._target import RingTarget
from calibore.optics import LENS_LAWS
from calibore.simulation import Sensor, photograph_rings
from calibore.simulation._files import write_png
from calibore.simulation._targets._rings import target_pose

SPACING = 0.02
INK = 0.0014


def photograph(lens: LensModel, values, target: RingTarget, *, rings: int, size, rng, psf_sigma=1.0):
    """The picture (h, w, 3) of a target with 8 spokes."""
    return photograph_rings(
        lens.camera(values, width=size[0], height=size[1]),
        target_pose(target.plane, centre=(target.centre_x, target.centre_y), roll=target.roll),
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

"""Rigs, and their looks at flats and gauges that are not quite where they seem to be: calibrations by chance."""

import numpy as np
from known_marks import flat_looks, gauge_look

from calibore.lasers import Cone, Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing, moved, value_of

INCH = 0.0254
AIM, PIXELS = float(np.radians(19.9)), float(1 / np.radians(0.0175))
CAMERA = Camera(1024, 768, Lens("equidistant", 420.0, 384.0), (515.0, 381.0))
PLANE = Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.12, 0.008, -0.005), "red"),))
CONE = Rig("single-cone", CAMERA, (Laser(Cone.for_ring(0.05, 0.18, 0.12, clock=0.1), "red"),))
COAXIAL = Rig("coaxial-cone", CAMERA, (Laser(Cone(0.0, 0.0, 0.7, offset=0.05), "red"),))
CENTRES = ((0.008, 0.004), (-0.006, 0.01), (0.01, -0.008), (-0.004, -0.006))
SIZES = (0.20, 0.23, 0.25, 0.28)
U_GAUGE = 5e-6


def head(baseline=2.355 * INCH, aim=AIM, k=PIXELS, lean=0.0):
    camera = Camera(1024, 768, Lens("equidistant", k, 384.0), (512.0, 384.0))
    return Rig("side-facing", camera, (Laser(Sheet(lean=lean), "red"),), mount=SideFacing(baseline, aim))


def random_head(rng, *, stated, stops=9, u_range=3e-5, wrong=None, rows=24):
    """A head by chance, a design that is a little wrong, and looks at a flat at `stops` ranges."""
    baseline, near, far = rng.uniform(1.8, 3.6) * INCH, 4.4 * INCH, 12 * INCH
    aim = float(np.arctan2(baseline, [4.2 * INCH, far]).mean())
    k = 470 / (np.arctan2(baseline, 4.2 * INCH) - aim)
    true = head(baseline, aim, k, rng.normal() * 2e-3)
    design = head(baseline * rng.uniform(0.96, 1.04), aim + 0.008 * rng.normal(), k * rng.uniform(0.95, 1.05))
    looks = flat_looks(
        true,
        np.linspace(near, far, stops),
        rng,
        u_range=u_range,
        stated=stated,
        slope=5e-3 * rng.normal(),
        wrong=wrong,
        rows=rows,
    )
    return true, design, looks


def looks_at_gauges(rig, rng, *, sizes=SIZES, wrong=None, marks=64):
    """Gauges set up off the middle and inclined by chance, their radii wrong by chance."""
    return [
        gauge_look(
            rig,
            size,
            rng,
            name=f"gauge {1e3 * size:.0f} mm, {number}",
            centre=CENTRES[number % 4],
            slope=tuple(0.008 * rng.standard_normal(2)),
            u=U_GAUGE,
            u_tilt=0.008,
            off=U_GAUGE * rng.standard_normal() + (wrong or {}).get(number, 0.0),
            marks=marks,
        )
        for number, size in enumerate(sizes)
    ]


def designed(rig, rng):
    """The rig as its file would describe it: not quite as it is."""
    off = {"baseline": 0.001, "aim": 0.005, "half_angle": 0.005, "clock": 0.005, "offset": 0.0005}
    changes = {
        f"laser.{key}": u * rng.standard_normal() for key, u in off.items() if f"laser.{key}" in rig.parameter_names
    }
    if rig.configuration == "coaxial-cone":
        changes = {name: change for name, change in changes.items() if name in ("laser.half_angle", "laser.offset")}
    tilts = {name: -value_of(rig, name) for name in ("laser.tilt_x", "laser.tilt_y") if name in rig.parameter_names}
    return moved(rig, changes | tilts)

"""Rigs of every kind by chance, for the compiled engine and its twin."""

import numpy as np

from calibore.lasers import Beam, Cone, Plane, Sheet
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.rigs import FORWARD, Laser, Rig, SideFacing
from calibore.uncertainty import Covariance

KINDS = ("plane", "cone", "coaxial", "reversed", "dual", "sheet", "beam")
WIDTH, HEIGHT = 640, 480


def random_rig(rng, kind):
    """(rig, laser, prior radius): any of five laws, half with a residual, everything uncertain and correlated."""
    size = float(np.exp(rng.uniform(np.log(0.05), np.log(0.5))))
    surfaces, mount, laser = _surfaces(rng, kind, size), FORWARD, 1 if kind == "dual" else 0
    if kind == "sheet":
        mount = SideFacing(rng.uniform(0.2, 0.6) * size, rng.uniform(0.2, 0.9))
    law = str(rng.choice(tuple(LENS_LAWS)))
    bends = rng.uniform(-0.06, 0.06, 2) * (rng.uniform() < 0.5)
    k = rng.uniform(0.6, 1.4) * HEIGHT / 2 * (1.3 if law in ("sine-law", "equisolid-angle") else 1)
    centre = (WIDTH / 2 + rng.uniform(-20, 20), HEIGHT / 2 + rng.uniform(-20, 20))
    lens = Lens(law, float(k), HEIGHT / 2, float(bends[0]), float(bends[1]))
    camera = Camera(WIDTH, HEIGHT, lens, centre, float(rng.uniform(0.9, 1.1)))
    rig = Rig("any", camera, tuple(Laser(surface) for surface in surfaces), mount=mount)
    return rig.knowing(_covariance(rng, rig, size)), laser, size


def _surfaces(rng, kind, size):
    if kind == "plane":
        return (Plane(rng.uniform(0.6, 3) * size, *rng.uniform(-0.3, 0.3, 2)),)
    if kind == "sheet":
        return (Sheet(rng.uniform(-0.02, 0.02) * size, *rng.uniform(-0.05, 0.05, 2)),)
    if kind == "beam":
        return (Beam(*(rng.uniform(0.1, 0.3, 2) * size), 0.02 * size, rng.uniform(0.3, 1.2), rng.uniform(0, 6.3)),)
    if kind == "coaxial":
        return (Cone(0.0, 0.0, rng.uniform(0.3, 1.2), 0.0, rng.uniform(0.1, 1.0) * size),)
    if kind == "reversed":
        return (Cone(0.0, 0.0, np.pi - rng.uniform(0.4, 1.2), 0.0, rng.uniform(1.5, 3.0) * size),)
    cones = [_cone(rng, size, rng.uniform(0, 6.3)) for _ in range(2 if kind == "dual" else 1)]
    return tuple(cones)


def _cone(rng, size, clock):
    return Cone.for_ring(rng.uniform(0.2, 0.8) * size, rng.uniform(0.5, 2) * size, size, clock=float(clock))


def _covariance(rng, rig, size):
    """All parameters of all lasers, the mount and the camera, with random correlations of low rank."""
    lengths = {"baseline", "offset", "x", "y", "z"}
    scale = {"k": 0.3, "principal_point_u": 0.4, "principal_point_v": 0.4}
    names = rig.parameter_names
    u = [scale.get(n.split(".")[-1], 1e-4 * size if n.split(".")[-1] in lengths else 2e-4) for n in names]
    factor = rng.normal(size=(len(names), 4)) + 3 * np.eye(len(names), 4)
    factor *= np.array(u)[:, None] / np.linalg.norm(factor, axis=1, keepdims=True)
    return Covariance(names, factor @ factor.T)


def random_pixels(rng, n):
    return rng.uniform(-40, WIDTH + 40, n), rng.uniform(-40, HEIGHT + 40, n)

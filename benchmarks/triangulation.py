"""A million pixels to wall points with uncertainty: the engine against closed forms in NumPy and with `uncertainties`."""

from functools import partial

import numpy as np

from benchmarks.peers import closed_forms as peer
from benchmarks.timing import compare
from calibore.lasers import Cone, Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig
from calibore.rigs._measuring import measure
from calibore.uncertainty import Covariance

RADIUS, POINTS, FEW = 0.15, 1_000_000, 2000
U_PIXEL, K, CENTRE = 0.3, 320.0, (511.5, 383.5)
REFERENCE = "closed form, NumPy"
RELATIVE_U = (5e-4, 5e-4, 5e-4, 5e-4)
CORRELATION = 0.3
GEOMETRIES = {"plane": (0.15, 0.01, -0.02), "cone": tuple(vars(Cone.for_ring(0.075, 0.15, RADIUS)).values())[:3]}


def report(rounds: int = 15) -> list[str]:
    """Markdown lines."""
    lines = ["## Triangulation: R, H, clock and their uncertainty for 1 000 000 pixels, equidistant lens"]
    for kind in GEOMETRIES:
        rig, given = _rig(kind)
        u, v = _pixels(POINTS)
        form = getattr(peer, kind)
        contestants = {
            "calibore measure, one thread": partial(_ours, rig, u, v, 1),
            "calibore measure, two threads": partial(_ours, rig, u, v, 2),
            REFERENCE: partial(form, u, v, given),
            "closed form, NumPy, in blocks of 8192": partial(peer.in_blocks, form, u, v, given),
        }
        with np.errstate(all="ignore"):
            result = compare(contestants, peer=REFERENCE, rounds=rounds, rng=np.random.default_rng(1))
            slow = _against_uncertainties(kind, rig, given)
            worst = _agreement(_ours(rig, u, v, 2), form(u, v, given))
        lines += ["", f"### {kind}", f"The two agree within {worst:.0e}.", "| contestant | median ms | peer / contestant |"]
        lines += ["|---|---|---|", *result.rows(), "", *slow]
    return lines


def _against_uncertainties(kind, rig, given):
    u, v = _pixels(FEW)
    name = "`uncertainties`, point by point"
    contestants = {
        "calibore measure, one thread": partial(_ours, rig, u, v, 1),
        name: partial(peer.by_uncertainties, kind, u, v, given),
    }
    result = compare(contestants, peer=name, rounds=5, rng=np.random.default_rng(2))
    return [f"| contestant ({FEW} points) | median ms | peer / contestant |", "|---|---|---|", *result.rows()]


def _ours(rig, u, v, threads):
    return measure(rig, u, v, u_pixel=U_PIXEL, prior_radius=RADIUS, threads=threads)


def _agreement(ours, theirs):
    names = ("radius", "axial", "clock", *(f"u_{q}_{p}" for q in ("radius", "axial") for p in ("independent", "common")))
    pairs = ((getattr(ours, name), row) for name, row in zip(names, theirs, strict=True))
    return max(float(np.nanmax(np.abs(a - b) / np.abs(b))) for a, b in pairs)


def _pixels(n):
    rng = np.random.default_rng(3)
    return rng.uniform(200, 824, n), rng.uniform(100, 668, n)


def _rig(kind):
    geometry = GEOMETRIES[kind]
    names = ("baseline", "aim", "half_angle") if kind == "cone" else ("baseline", "tilt_x", "tilt_y")
    paths = (*(f"laser.{name}" for name in names), "camera.k")
    u = np.array(RELATIVE_U) * (geometry[0], 1.0, 1.0, K)
    covariance = Covariance(paths, np.outer(u, u) * (CORRELATION + (1 - CORRELATION) * np.eye(4)))
    surface = Cone(*geometry) if kind == "cone" else Plane(*geometry)
    camera = Camera(1024, 768, Lens("equidistant", K, 384.0), CENTRE)
    configuration = "single-cone" if kind == "cone" else "perpendicular-plane"
    rig = Rig(configuration, camera, (Laser(surface),), covariance=covariance)
    return rig, peer.Inputs(geometry, K, covariance.factor(), CENTRE, U_PIXEL, RADIUS)

"""Pipes with known walls, and what a rig sees of them: marks without pictures."""

import numpy as np

from calibore.calibration._in_situ._file import ProfileFile, ProfileTarget
from calibore.calibration._in_situ._marks import Marks
from calibore.calibration._in_situ._wall import WallGrid, WallReference
from calibore.calibration._in_words import Unit
from calibore.lasers import Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing, moved

INCH = 0.0254
NOISE = 0.3  # px


def dented_wall(*, u=0.0):
    """Six inches, oval, with a dent and a bulge, on rings 0.1 in apart."""
    axial, clock = np.arange(60) * 0.1 * INCH, np.arange(200) * np.pi / 100
    z, c = np.meshgrid(axial, clock, indexing="ij")
    radius = 6.0 + 0.1 * np.cos(2 * (c - 0.4)) + 0.03 * np.cos(3 * c) + 0.01 * np.sin(5 * c)
    radius -= 0.5 * np.exp(-(((c - 4.5) / 0.5) ** 2) - ((z / INCH - 3) / 2.5) ** 2)
    radius += 0.6 * np.exp(-(((c - 1.5) / 0.5) ** 2) - ((z / INCH - 3) / 2.5) ** 2)
    return WallGrid(axial, clock, radius * INCH, u)


def plane_rig():
    camera = Camera(1024, 768, Lens("sine-law", 446.3, 384.0), (512.0, 384.0))
    return Rig("perpendicular-plane", camera, (Laser(Plane(6.85 * INCH), "red"),))


def side_rig():
    camera = Camera(1024, 768, Lens("equidistant", 3274.0, 384.0), (512.0, 384.0))
    return Rig("side-facing", camera, (Laser(Sheet(), "red"),), mount=SideFacing(2.355 * INCH, np.radians(19.9)))


def sightings(rig, wall, rng, *, pose=None, noise=NOISE, marks=40):
    """Marks of `rig` in the pipe; the reference lies at `pose` (6,) in the scan's frame."""
    pose = np.zeros(6) if pose is None else pose
    forward = not isinstance(rig.mount, SideFacing)
    return tuple(
        _look(rig, WallReference(wall, axial, roll, pose, np.ones(6)), name, noise, marks, rng)
        for name, axial, roll in (_rings(rig) if forward else _stops())
    )


def _rings(rig):
    return [(f"station {n}", 0.02 + 0.025 * n - rig.lasers[0].surface.baseline, 0.0) for n in range(4)]


def _stops():
    clocks = (0.0, 0.8, 1.2, 1.5, 1.8, 2.4, 3.2, 4.1, 4.5, 4.9, 5.6)
    return [(f"stop {n}", 0.075, clock + np.pi) for n, clock in enumerate(clocks)]


def _look(rig, reference, name, noise, count, rng):
    if isinstance(rig.mount, SideFacing):
        y, z, x = np.full(count, 0.15), np.linspace(-0.015, 0.015, count), np.zeros(count)
        arms = np.stack([x, np.ones(count), np.zeros(count)], axis=1)
        start, direction = np.stack([x, y, z], axis=1), np.tile([1.0, 0.0], (count, 1))
    else:
        clock = np.arange(count) * 2 * np.pi / count
        arms = np.stack([np.sin(clock), -np.cos(clock), np.zeros(count)], axis=1)
        start = 0.15 * arms + [0, 0, rig.lasers[0].surface.baseline]
        direction = arms[:, :2]
    for _ in range(8):
        gap = reference.gap(start, np.zeros(6))
        start = start - arms * (gap.value / np.einsum("ni,ni->n", gap.by_point, arms))[:, None]
    u, v = rig.project(start)
    off = rng.normal(0, noise, count)
    u, v = u + off * direction[:, 0], v + off * direction[:, 1]
    return Marks(name, u, v, direction, np.full(count, 0.5), reference.axial, reference.roll)


def target(rig, wall, folder):
    said = ProfileFile(format="calibore-target/1", kind="profile", rig="rig.toml", profile="out")
    return ProfileTarget(folder / "target.toml", said, rig, wall, Unit("in", INCH), ())


def drawn(rig, covariance, rng):
    """A rig as it may really be, if `rig` is how it was calibrated."""
    change = covariance.draw(rng, 1)[0]
    return moved(rig, dict(zip(covariance.names, change.tolist(), strict=True)))

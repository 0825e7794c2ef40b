"""Marks that a finder would give of a ring target, made from the camera and the target's place: for the tests."""

from dataclasses import dataclass, replace

import numpy as np

from calibore.calibration._lens_models import CENTRE, LensModel
from calibore.calibration._rings._model import Printed
from calibore.calibration._rings._sight import Sight
from calibore.calibration._rings._target import RingTarget
from calibore.optics import LENS_LAWS, Camera
from calibore.targets import RingMarks

CLEAR = 3.0
"""px between marks and the crossing lines of the other kind, where a finder would be disturbed."""


@dataclass(frozen=True)
class Noise:
    """Of marks [px]: `mark` of each, correlated by `neighbours` with the next on its line; `line`: shared by a line."""

    mark: float = 0.05
    neighbours: float = 0.0
    line: float = 0.0


def exact_marks(camera: Camera, target: RingTarget, radii, *, spokes=8, per_ring=720, ink_width=0.0) -> RingMarks:
    """All marks in the frame, on rings of `radii` [m] and on `spokes`."""
    parts = [_ring(camera, target, radius, i + 1, per_ring, ink_width) for i, radius in enumerate(radii)]
    parts += [_spoke(camera, target, i, spokes, max(radii)) for i in range(spokes)]
    u, v, direction, ring, spoke = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    seen = (u > 2) & (u < camera.width - 3) & (v > 2) & (v < camera.height - 3)
    centre = camera.project(target.point(np.zeros(1), np.zeros(1)))
    marks = RingMarks(u, v, direction, np.full(u.size, 0.05), ring, spoke, (float(centre[0][0]), float(centre[1][0])))
    return only(marks, seen)


def _ring(camera, target, radius, number, n, ink):
    angle = (np.arange(n) + 0.5) * 2 * np.pi / n
    inner, outer = (
        np.stack(camera.project(target.point(np.full(n, radius + way * max(ink, 1e-6) / 2), angle)), 1)
        for way in (-1, 1)
    )
    middle, direction = (inner + outer) / 2, outer - inner
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return *middle.T, direction, np.full(n, number), np.full(n, -1)


def _spoke(camera, target, number, spokes, longest, n=120):
    angle = np.full(n, number * 2 * np.pi / spokes)
    radius = np.linspace(0.08, 1.0, n) * longest
    u, v = camera.project(target.point(radius, angle))
    aside = np.stack(camera.project(target.point(radius, angle + 1e-4)), 1) - np.stack([u, v], 1)
    direction = aside / np.linalg.norm(aside, axis=1, keepdims=True)
    return u, v, direction, np.zeros(n, dtype=int), np.full(n, number)


def only(marks: RingMarks, rows) -> RingMarks:
    """The marks of some `rows`."""
    fields = {name: getattr(marks, name)[rows] for name in ("u", "v", "direction", "sigma", "ring", "spoke")}
    return replace(marks, **fields)


def noisy(marks: RingMarks, noise: Noise, rng: np.random.Generator) -> RingMarks:
    """`marks` moved along their directions as `noise` says."""
    line = np.where(marks.ring > 0, marks.ring, -1 - marks.spoke)
    shift = np.zeros(line.size)
    for one in np.unique(line):
        rows = np.flatnonzero(line == one)
        shift[rows] = noise.line * rng.standard_normal() + _series(rows.size, noise, rng)
    return replace(
        marks,
        u=marks.u + shift * marks.direction[:, 0],
        v=marks.v + shift * marks.direction[:, 1],
        sigma=np.full(line.size, noise.mark),
    )


def _series(n, noise, rng):
    """Noise of n neighbours, correlated as in a chain of the first order."""
    fresh = rng.standard_normal(n) * noise.mark
    for i in range(1, n):
        fresh[i] = noise.neighbours * fresh[i - 1] + np.sqrt(1 - noise.neighbours**2) * fresh[i]
    return fresh


@dataclass(frozen=True, eq=False)
class Case:
    """A random calibration at the level of marks, and its truth by dotted path."""

    sight: Sight
    lens: LensModel
    truth: dict[str, float]
    radii: np.ndarray


FINDER_ERROR = 0.001
"""px: what all marks err alike; the calibration states it."""
LAWS = ("stereographic", "equidistant", "sine-law", "equisolid-angle")


def random_case(rng: np.random.Generator, *, per_ring: int = 360) -> Case:
    """A camera before a target of 6 ... 12 rings that fills its image out to a zenith of 35 ... 70 deg, within 3 deg of
    square, its radii printed with errors of known size in every second case; noise of marks is correlated with the
    next, and lines err as a whole by up to a seventh of it.
    """
    law = str(rng.choice(LAWS))
    rings, spacing = int(rng.integers(6, 13)), float(rng.choice([0.0254, 0.02]))
    radii = spacing * np.arange(1, rings + 1)
    widest = np.radians(rng.uniform(35, 70))
    baseline = float(radii[-1] / np.tan(widest))
    k = float(rng.uniform(0.85, 0.95) * 384 / LENS_LAWS[law].ratio(widest))
    values = {"camera.k": k, "camera.aspect": float(rng.uniform(0.98, 1.02))}
    values |= {CENTRE[0]: float(511.5 + rng.normal(0, 10)), CENTRE[1]: float(383.5 + rng.normal(0, 10))}
    camera = LensModel(law).camera(values, width=1024, height=768)
    tilt, aside = rng.normal(0, 0.02, 2), rng.normal(0, 0.02, 2) * radii[-1]
    target = RingTarget(baseline, *tilt.tolist(), *aside.tolist(), float(rng.uniform(-np.pi, np.pi)))
    u_ring = float(rng.choice([0.0, 2e-5]))
    ink = 0.05 * spacing
    printed = radii + rng.normal(0, u_ring, rings)
    mark = float(rng.uniform(0.02, 0.1))
    noise = Noise(mark, float(rng.uniform(0, 0.5)), mark * float(rng.uniform(0, 0.15)))
    marks = noisy(exact_marks(camera, target, printed, per_ring=per_ring, ink_width=ink), noise, rng)
    marks = shifted(marks, rng.normal(0, FINDER_ERROR, 3))
    nominal = baseline * float(rng.uniform(0.8, 1.1))
    sight = Sight(Printed(radii, 8, ink), (marks,), (1024, 768), nominal, u_ring=u_ring)
    values |= {"laser.baseline": baseline, "laser.tilt_x": target.tilt_x, "laser.tilt_y": target.tilt_y}
    return Case(sight, LensModel(law), values, radii)


def shifted(marks: RingMarks, shift) -> RingMarks:
    """All marks (right, down) [px] from where they were, those on rings outwards."""
    outwards = np.stack([marks.u - marks.centre[0], marks.v - marks.centre[1]], 1)
    sign = np.sign(np.sum(outwards * marks.direction, axis=1)) * (marks.ring > 0)
    along = marks.direction @ shift[:2] + shift[2] * sign
    return replace(marks, u=marks.u + along * marks.direction[:, 0], v=marks.v + along * marks.direction[:, 1])

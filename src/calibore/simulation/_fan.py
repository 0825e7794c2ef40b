"""The light of a laser: a fan of rays from one source, each followed to the first wall it meets."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.lasers import Cone, LaserSurface, Plane, Sheet
from calibore.rigs import Rig
from calibore.simulation._roots import Function, bracketed_roots
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

SETTLED = 1e-13  # m
STRIDE, MOST_STRIDES = 0.008, 400  # nominal radii: how densely a ray is searched for the first of several walls in line
FARTHEST = 30.0  # nominal radii; light that meets no wall up to here meets none
AT_ONCE = 2000  # points of rays looked at in one call
SPARE = 1e-6  # of the nominal radius, so that rounding puts no wall outside those radii
HALF_SHEET = np.radians(60.0)  # of the fan of a side-facing laser, wider than its camera sees


@dataclass(frozen=True, eq=False)
class Fan:
    """Light from `source` (3,) [m], its rays `along` + cos(angle) `even` + sin(angle) `odd`, (3,) each; pipe frame.

    A `closed` fan covers the whole turn, clockwise from the crown of the rig; another one +-`HALF_SHEET`.
    """

    surface: LaserSurface
    rig_from_pipe: Pose
    source: Array
    along: Array
    even: Array
    odd: Array
    closed: bool = True

    @classmethod
    def of(cls, rig: Rig, pipe_from_rig: Pose, *, laser: int, offset: float = 0.0) -> "Fan":
        """The light of `laser`, or of a leaf of it that lies `offset` [m] beside its middle."""
        surface = rig.lasers[laser].surface
        source, *parts = _rays_of(surface)
        source = source + offset * _beside(surface, *parts)
        turned = (pipe_from_rig.rotation @ part for part in parts)
        closed = not isinstance(surface, Sheet)
        return cls(surface, pipe_from_rig.inverse(), pipe_from_rig.apply(source), *turned, closed=closed)

    @property
    def limits(self) -> tuple[float, float]:
        """First and last angle [rad]."""
        return (0.0, 2 * np.pi) if self.closed else (-HALF_SHEET, HALF_SHEET)

    def first_wall(self, wall: PipeWall, angle: Array) -> Array:
        """The wall points (n, 3) of the pipe frame that the rays at `angle` (n,) [rad] light; NaN where none is."""
        rays = self.along + np.cos(angle)[:, None] * self.even + np.sin(angle)[:, None] * self.odd
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        return self.source + distance_to_wall(wall, self.source, rays)[:, None] * rays

    def normal(self, points: Array) -> Array:
        """The unit normal (n, 3) of the laser surface at `points` (n, 3), pipe frame."""
        gradient = self.surface.gradient(self.rig_from_pipe.apply(points)) @ self.rig_from_pipe.rotation
        return gradient / np.linalg.norm(gradient, axis=1, keepdims=True)


def _rays_of(surface: LaserSurface) -> tuple[Array, Array, Array, Array]:
    """Source, along, even and odd part of a surface's light, in the rig frame."""
    nothing = np.zeros(3)
    if isinstance(surface, Plane):
        even, odd = np.array([0.0, -1.0, -surface.tilt_y]), np.array([1.0, 0.0, surface.tilt_x])
        return np.array([0.0, 0.0, surface.baseline]), nothing, even, odd
    if isinstance(surface, Sheet):
        even, odd = np.array([surface.skew, 1.0, 0.0]), np.array([surface.lean, 0.0, 1.0])
        return np.array([surface.offset, 0.0, 0.0]), nothing, even, odd
    if isinstance(surface, Cone):
        sine, cosine = np.sin(surface.clock), np.cos(surface.clock)
        round_ = np.array([cosine, sine, 0.0])
        outwards = np.cross(round_, surface.axis)
        across = np.sin(surface.half_angle)
        even, odd = across * (cosine * outwards - sine * round_), across * (sine * outwards + cosine * round_)
        return surface.apex, np.cos(surface.half_angle) * surface.axis, even, odd
    raise InputError(
        f"The light of a {type(surface).__name__} draws no line on the wall; simulate planes, cones, sheets."
    )


def _beside(surface: LaserSurface, along: Array, even: Array, odd: Array) -> Array:
    """How far (3,) the source is moved to move all of the light 1 m at right angles to itself."""
    if isinstance(surface, Cone):
        return along / np.linalg.norm(along) / np.sin(surface.half_angle)
    normal = np.cross(even, odd)
    return normal / np.linalg.norm(normal)


def distance_to_wall(wall: PipeWall, source: Array, rays: Array) -> Array:
    """Distance (n,) [m] from `source` (3,) along `rays` (n, 3) to the first wall; NaN where there is none.

    Followed in even steps through the shell that holds all of the wall; the step that leaves the open brackets it.
    """
    if wall.depth(source) >= 0:
        raise InputError("A laser stands outside the pipe, in the wall; correct its baseline or the pose of the rig.")

    def depth(distance: Array, index: NDArray[np.intp]) -> Array:
        return wall.depth(source + distance[:, None] * rays[index])

    spare = SPARE * wall.nominal_radius
    start = _leaves(source, rays, wall.clearance - spare, wall.nominal_radius)
    length = _leaves(source, rays, wall.extent + spare, wall.nominal_radius) - start
    strides = np.clip(np.ceil(length / (STRIDE * wall.nominal_radius)), 4, MOST_STRIDES).astype(np.intp)
    step = length / strides
    reached = _strides_in_the_open(depth, start, step, strides)
    met = np.flatnonzero(reached)
    low = start[met] + (reached[met] - 1) * step[met]
    distance = np.full(start.size, np.nan)
    distance[met] = bracketed_roots(lambda x, i: depth(x, met[i]), low, low + step[met], settled=SETTLED)
    return distance


def _strides_in_the_open(depth: Function, start: Array, step: Array, strides: NDArray[np.intp]) -> NDArray[np.intp]:
    """Number (n,) of the first of `strides` (n,) steps that ends inside the wall; 0 where none does."""
    reached, open_, taken = np.zeros(start.size, dtype=np.intp), np.arange(start.size), 0
    while open_.size:
        numbers = taken + 1 + np.arange(max(AT_ONCE // open_.size, 1))
        index = np.repeat(open_, numbers.size)
        inside = depth(start[index] + np.tile(numbers, open_.size) * step[index], index) > 0
        inside = inside.reshape(open_.size, numbers.size)
        hit = inside.any(axis=1)
        reached[open_[hit]] = numbers[inside.argmax(axis=1)[hit]]
        taken = int(numbers[-1])
        open_ = open_[~hit & (strides[open_] > taken)]
    return reached


def _leaves(source: Array, rays: Array, radius: float, nominal_radius: float) -> Array:
    """Where (n,) [m] rays from `source` leave the cylinder of `radius` [m]; 0 where they start outside it."""
    across, towards = np.sum(rays[:, :2] ** 2, axis=1), rays[:, :2] @ source[:2]
    within = radius**2 - source[:2] @ source[:2]
    far = FARTHEST * nominal_radius
    if within <= 0:
        return np.zeros(across.shape)
    parallel = across == 0
    root = np.sqrt(towards**2 + across * within)
    return np.minimum(np.where(parallel, far, (root - towards) / np.where(parallel, 1.0, across)), far)

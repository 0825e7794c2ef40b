"""Where along a lit line something is reached exactly: a clock position, an image row."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import Pose, clock_of
from calibore.rigs import Rig
from calibore.simulation._fan import Fan
from calibore.simulation._light import LineLight, LitLine, inside_image
from calibore.simulation._roots import bracketed_roots
from calibore.simulation._sight import sees, wall_normal
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]
Index = NDArray[np.intp]

SETTLED = 1e-13  # rad of the fan
REACHED = 1e-6  # rad or px; what remains further away was leapt over


class Found(NamedTuple):
    """Wall points (n, 3) of the rig frame, NaN where leapt over; whether the camera sees them lit; their signal."""

    points: Array
    visible: NDArray[np.bool_]
    signal: Array


@dataclass(frozen=True, eq=False)
class Crossings:
    """A line `lit` on `wall` by the light `fan` of a rig at `pose`."""

    lit: LitLine
    rig: Rig
    wall: PipeWall
    fan: Fan
    pupil: Array
    line: LineLight

    @classmethod
    def of(
        cls, lit: LitLine, rig: Rig, wall: PipeWall, *, pipe_from_rig: Pose, line: LineLight, laser: int
    ) -> "Crossings":
        fan = Fan.of(rig, pipe_from_rig, laser=laser)
        return cls(lit, rig, wall, fan, pipe_from_rig.apply(rig.mount.translation), line)

    def solve(self, at: Index, distance: Callable[[Array, Index], NDArray[Any]]) -> Found:
        """Where `distance(points, index)` is 0 between the points `at` (m,) of the line and the next ones; `points`
        (k, 3) of the rig frame belong to the crossings `index` (k,).
        """
        following = np.append(self.lit.angle[1:], self.lit.angle[0] + 2 * np.pi)
        low, high = self.lit.angle[at], following[at]
        before, after = (distance(self.lit.points[k % following.size], np.arange(at.size)) for k in (at, at + 1))
        sign = np.where(after > before, 1.0, -1.0)

        def ahead(angle: Array, index: Index) -> Array:
            points = self._rig_points(self.fan.first_wall(self.wall, angle))
            return sign[index] * np.nan_to_num(distance(points, index), nan=np.inf)

        angle = bracketed_roots(ahead, low, high, settled=SETTLED)
        return self._found(angle, np.abs(ahead(angle, np.arange(at.size))) < REACHED)

    def _found(self, angle: Array, reached: NDArray[np.bool_]) -> Found:
        pipe_points = self.fan.first_wall(self.wall, angle)
        points = self._rig_points(pipe_points)
        clock = clock_of(points[:, 0], points[:, 1])
        visible = reached & inside_image(*self.rig.project(points), self.rig) & self.line.lights(clock)
        visible &= self.wall.dry(pipe_points)
        lit = pipe_points[visible]
        normal = wall_normal(self.wall, lit, clock_of(lit[:, 0], lit[:, 1]))
        visible[visible] = sees(self.wall, lit, self.pupil, normal=normal)
        period = 2 * np.pi if self.lit.closed else None
        signal = np.interp(angle, self.lit.angle, self.lit.signal, period=period)
        return Found(np.where(reached[:, None], points, np.nan), visible, np.where(visible, signal, 0.0))

    def _rig_points(self, points: Array) -> Array:
        return self.fan.rig_from_pipe.apply(points)

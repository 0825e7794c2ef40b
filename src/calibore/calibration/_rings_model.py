"""Marks of a ring target, triangulated onto its plane: how far they are from the rings and spokes they belong to."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.calibration._rings_target import Place, RingTarget
from calibore.optics import Camera
from calibore.rigs import Laser, Rig, triangulate
from calibore.targets import RingMarks

Array = NDArray[np.float64]

PLANE = ("laser.baseline", "laser.tilt_x", "laser.tilt_y")
LOST = 1e3
"""px: residual of a mark that the lens cannot image; no step of a fit may end there."""


class Printed(NamedTuple):
    """What is printed: `radii` [m] of the rings, innermost first, how many `spokes`, `ink_width` [m] of the lines."""

    radii: Array
    spokes: int
    ink_width: float = 0.0


@dataclass(frozen=True, eq=False)
class RingModel:
    """Predicts where the marks of several pictures of one target lie; a model for `fitting.least_squares`.

    Parameters `names`: those of the `lens`, the pixels' aspect unless `square`, the principal point, and the
    `RingTarget` of each picture; with `printed_errors` the error [m] of each ring's printed radius.
    """

    lens: LensModel
    printed: Printed
    marks: tuple[RingMarks, ...]
    size: tuple[int, int]
    square: bool = False
    printed_errors: bool = False
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        names = [*self.lens.parameters, *(() if self.square else (ASPECT,)), *CENTRE]
        names += [name for number in range(len(self.marks)) for name in target_names(number)]
        if self.printed_errors:
            names += [f"target.ring_{ring}" for ring in range(1, self.printed.radii.size + 1)]
        object.__setattr__(self, "names", tuple(names))

    def __call__(self, values: Array) -> tuple[Array, Array]:
        """Residuals (n,) [px] along each mark's direction, measured minus predicted, and the Jacobian (n, p) of the
        predictions.
        """
        residuals, jacobian = np.zeros(self._size), np.zeros((self._size, len(self.names)))
        camera, start = self.camera(values), 0
        for number, marks in enumerate(self.marks):
            rows = slice(start, start + marks.u.size)
            residuals[rows], jacobian[rows] = self._one_picture(values, camera, number)
            start = rows.stop
        lost = ~np.isfinite(residuals)
        residuals[lost], jacobian[lost] = LOST, 0.0
        return residuals, jacobian

    def camera(self, values: Array) -> Camera:
        return self.lens.camera(dict(zip(self.names, values, strict=True)), width=self.size[0], height=self.size[1])

    def target(self, values: Array, number: int) -> RingTarget:
        """Where the target was in picture `number`."""
        place = dict(zip(self.names, values, strict=True))
        return RingTarget(*(float(place[name]) for name in target_names(number)))

    def rig(self, values: Array, number: int) -> Rig:
        """The camera, and a plane of light where the target was in picture `number`."""
        laser = Laser(self.target(values, number).plane)
        return Rig("perpendicular-plane", self.camera(values), (laser,))

    @cached_property
    def _size(self) -> int:
        return sum(marks.u.size for marks in self.marks)

    def _one_picture(self, values: Array, camera: Camera, number: int) -> tuple[Array, Array]:
        marks, target = self.marks[number], self.target(values, number)
        rig = Rig("perpendicular-plane", camera, (Laser(target.plane),))
        residuals, jacobian = np.zeros(marks.u.size), np.zeros((marks.u.size, len(self.names)))
        columns = [self.names.index(name) for name in target_names(number)]
        known = [i for i, name in enumerate(rig.parameter_names) if name in self.names and name not in PLANE]
        cameras = [self.names.index(rig.parameter_names[i]) for i in known]
        for rows, beside in ((np.flatnonzero(marks.ring > 0), False), (np.flatnonzero(marks.ring == 0), True)):
            found = triangulate(rig, marks.u[rows], marks.v[rows])
            place = (
                self._beside_spoke(found.points, marks.spoke[rows], target) if beside else target.radius(found.points)
            )
            by_point = place.by_point[:, None, :]
            slope = np.einsum("nij,nj->ni", by_point @ found.d_pixel, marks.direction[rows])[:, 0]
            by_rig = (by_point @ found.d_parameters)[:, 0]
            by_target = place.by_parameters.copy()
            by_target[:, :3] += by_rig[:, :3]
            gap = place.value if beside else self._beyond_ring(values, place.value, slope, marks, rows, rig, target)
            residuals[rows] = gap / slope
            jacobian[np.ix_(rows, columns)] = -by_target / slope[:, None]
            jacobian[np.ix_(rows, cameras)] = -by_rig[:, known] / slope[:, None]
            if self.printed_errors and not beside:
                jacobian[rows, len(self.names) - self.printed.radii.size + marks.ring[rows] - 1] = 1 / slope
        return residuals, jacobian

    def _beside_spoke(self, points: Array, spoke: NDArray[np.intp], target: RingTarget) -> Place:
        return target.across(points, spoke * (2 * np.pi / self.printed.spokes))

    def _beyond_ring(
        self,
        values: Array,
        radius: Array,
        slope: Array,
        marks: RingMarks,
        rows: NDArray[np.intp],
        rig: Rig,
        target: RingTarget,
    ) -> Array:
        """How far beyond its ring a mark is [m]. It is the middle between the edges of the ink as they appear, not the
        image of the ink's middle: the radii of its edges, not its own, have the printed radius as their mean.
        """
        printed = self.printed.radii
        if self.printed_errors:
            printed = printed + values[-printed.size :]
        if self.printed.ink_width:
            half = (self.printed.ink_width / 2 / np.abs(slope))[:, None] * marks.direction[rows]
            u, v = marks.u[rows], marks.v[rows]
            edges = [_radius(rig, target, u + way * half[:, 0], v + way * half[:, 1]) for way in (-1, 1)]
            radius = (edges[0] + edges[1]) / 2
        return radius - printed[marks.ring[rows] - 1]


def _radius(rig: Rig, target: RingTarget, u: Array, v: Array) -> Array:
    """Distance from the target's centre of what the pixels show, without sensitivities: ten times faster."""
    rays = rig.camera.unproject(u, v)
    distance = target.plane.meet(*rays).distance[0]
    return target.radius(rays.origin + distance[:, None] * rays.direction).value


def target_names(number: int) -> tuple[str, ...]:
    """Names of the place of the target in picture `number`; in the first it is where the rig's light shall be."""
    if number == 0:
        return (*PLANE, "target.centre_x", "target.centre_y", "target.roll")
    return tuple(f"target.{number}.{name}" for name in RingTarget.parameter_names)

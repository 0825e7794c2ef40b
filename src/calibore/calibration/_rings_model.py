"""Marks of a ring target, triangulated onto its plane: how far they are from the rings and spokes they belong to."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.calibration._rings_target import RingTarget
from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import Laser, Rig, triangulate
from calibore.targets import RingMarks

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

PLANE = ("laser.baseline", "laser.tilt_x", "laser.tilt_y")
FINDER = ("finder.right", "finder.down", "finder.outwards")


class Printed(NamedTuple):
    """What is printed: `radii` [m] of the rings, innermost first, how many `spokes`, `ink_width` [m] of the lines."""

    radii: Array
    spokes: int
    ink_width: float = 0.0


@dataclass(frozen=True, eq=False)
class RingModel:
    """Predicts where the marks of several pictures of one target lie; a model for `fitting.least_squares`.

    Parameters `names`: those of the `lens`, the pixels' aspect unless `square`, the principal point, the `RingTarget`
    of each picture; `FINDER`: how far [px] all marks are found too far right, down, and those of rings outwards; with
    `printed_errors` the error [m] of each ring's printed radius.
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
        names += FINDER
        if self.printed_errors:
            names += [f"target.ring_{ring}" for ring in range(1, self.printed.radii.size + 1)]
        object.__setattr__(self, "names", tuple(names))

    def __call__(self, values: Array) -> tuple[Array, Array]:
        """Residuals (n,) [px] along each mark's direction, measured minus predicted, and the Jacobian (n, p) of the
        predictions; NaN for marks that the lens does not image.
        """
        try:
            camera, targets = self.camera(values), [self.target(values, i) for i in range(len(self.marks))]
            rigs = [Rig("perpendicular-plane", camera, (Laser(target.plane),)) for target in targets]
        except InputError:  # no such camera: a step that went too far
            n = sum(marks.u.size for marks in self.marks)
            return np.full(n, np.nan), np.full((n, len(self.names)), np.nan)
        parts = [self._one_picture(values, rig, targets[i], i) for i, rig in enumerate(rigs)]
        residuals, jacobians = zip(*parts, strict=True)
        return np.concatenate(residuals), np.concatenate(jacobians)

    def pixels_per_metre(self, values: Array) -> Array:
        """(n,) how far [px] each mark moves along its direction if its line is printed 1 m farther out or aside."""
        rigs = [self.rig(values, i) for i in range(len(self.marks))]
        scales = []
        for number, marks in enumerate(self.marks):
            scale = np.zeros(marks.u.size)
            for rows in _rings_and_spokes(marks):
                scale[rows] = 1 / self._gap(values, rigs[number], self.target(values, number), marks, rows).slope
            scales.append(scale)
        return np.concatenate(scales)

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

    def _one_picture(self, values: Array, rig: Rig, target: RingTarget, number: int) -> tuple[Array, Array]:
        marks, known = self.marks[number], [name for name in rig.parameter_names if name not in PLANE]
        residuals, jacobian = np.zeros(marks.u.size), np.zeros((marks.u.size, len(self.names)))
        columns = [self.names.index(name) for name in target_names(number)]
        fitted = [i for i, name in enumerate(known) if name in self.names]
        cameras = [self.names.index(known[i]) for i in fitted]
        finder = [self.names.index(name) for name in FINDER]
        for rows in _rings_and_spokes(marks):
            gap = self._gap(values, rig, target, marks, rows)
            shifts = np.column_stack([marks.direction[rows], np.sign(gap.slope) * (marks.ring[rows] > 0)])
            residuals[rows] = gap.value / gap.slope - shifts @ values[finder]
            jacobian[np.ix_(rows, finder)] = shifts
            jacobian[np.ix_(rows, columns)] = -gap.by_target / gap.slope[:, None]
            jacobian[np.ix_(rows, cameras)] = -gap.by_camera[:, fitted] / gap.slope[:, None]
            if self.printed_errors and marks.ring[rows[0]]:
                jacobian[rows, len(self.names) - self.printed.radii.size + marks.ring[rows] - 1] = 1 / gap.slope
        return residuals, jacobian

    def _gap(self, values: Array, rig: Rig, target: RingTarget, marks: RingMarks, rows: Whole) -> "Gap":
        u, v, direction = marks.u[rows], marks.v[rows], marks.direction[rows]
        found = triangulate(rig, u, v)
        if marks.ring[rows[0]]:
            place = target.radius(found.points)
        else:
            place = target.across(found.points, marks.spoke[rows] * (2 * np.pi / self.printed.spokes))
        by_point = place.by_point[:, None, :]
        slope = np.einsum("nij,nj->ni", by_point @ found.d_pixel, direction)[:, 0]
        by_rig = (by_point @ found.d_parameters)[:, 0]
        by_target = place.by_parameters + np.pad(by_rig[:, :3], [(0, 0), (0, 3)])
        value = place.value
        if marks.ring[rows[0]]:
            half = (self.printed.ink_width / 2 / slope)[:, None] * direction
            value = _middle_of_edges(rig, target, (u, v), half) if self.printed.ink_width else value
            value = value - self._radii(values)[marks.ring[rows] - 1]
        return Gap(value, slope, by_target, by_rig[:, 3:])

    def _radii(self, values: Array) -> Array:
        printed = self.printed.radii
        return printed + values[-printed.size :] if self.printed_errors else printed


class Gap(NamedTuple):
    """How far marks are beyond their rings or beside their spokes, `value` (m,) [m], its `slope` (m,) [m/px] along
    their directions, its derivatives by the place of the target (m, 6) and by the camera (m, c).
    """

    value: Array
    slope: Array
    by_target: Array
    by_camera: Array


def _rings_and_spokes(marks: RingMarks) -> list[Whole]:
    rows = np.flatnonzero(marks.ring > 0), np.flatnonzero(marks.ring == 0)
    return [some for some in rows if some.size]


def _middle_of_edges(rig: Rig, target: RingTarget, pixels: tuple[Array, Array], half: Array) -> Array:
    """A mark is the middle between the edges of the ink as they appear, `half` (n, 2) [px] away, not the image of the
    ink's middle: the radii of its edges, not its own, have the printed radius as their mean.
    """
    edges = [_radius(rig, target, pixels[0] + way * half[:, 0], pixels[1] + way * half[:, 1]) for way in (-1, 1)]
    return (edges[0] + edges[1]) / 2


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
